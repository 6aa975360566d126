#include <fstream>

#include "rig_file.h"
#include "unreadable.h"

namespace berth
{

std::string read_file(const std::string &path, std::size_t at_most_bytes)
{
    std::ifstream file(path, std::ios::binary);
    constexpr std::size_t at_once_bytes = 1 << 20;
    std::string text;
    while (file.good()) {
        const std::size_t before = text.size();
        text.resize(before + at_once_bytes);
        file.read(&text[before], at_once_bytes);
        text.resize(before + static_cast<std::size_t>(file.gcount()));
        if (text.size() > at_most_bytes) {
            throw input_error(path + ": is larger than " + std::to_string(at_most_bytes >> 20) +
                              " MB, as no such file is; is it another file, or a device?");
        }
    }
    if (!file.is_open() || file.bad()) {
        throw input_error(unreadable(path));
    }
    return text;
}

} // namespace berth
