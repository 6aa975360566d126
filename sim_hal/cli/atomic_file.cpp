#include "atomic_file.h"

#include "../../hal/rig/rig_file.h"

namespace berth
{

atomic_file::atomic_file(const std::string &path)
    : path_(path), partial_(path + ".partial"), file_(std::fopen(partial_.c_str(), "wb"))
{
    if (file_ == nullptr) {
        fail();
    }
}

atomic_file::~atomic_file()
{
    if (file_ != nullptr) {
        std::fclose(file_);
    }
    if (!has_appeared_) {
        std::remove(partial_.c_str());
    }
}

void atomic_file::write(std::string_view text)
{
    if (std::fwrite(text.data(), 1, text.size(), file_) != text.size()) {
        fail();
    }
}

void atomic_file::close()
{
    std::FILE *const file = file_;
    file_ = nullptr;
    if (file != nullptr && std::fclose(file) != 0) {
        fail();
    }
}

void atomic_file::finish()
{
    close();
    has_appeared_ = std::rename(partial_.c_str(), path_.c_str()) == 0;
    if (!has_appeared_) {
        fail();
    }
}

void atomic_file::fail()
{
    throw input_error(path_ + ": cannot be written; is the folder writable and the disk not full?");
}

} // namespace berth
