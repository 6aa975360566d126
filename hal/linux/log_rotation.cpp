#include "log_rotation.h"

#include <fcntl.h>
#include <unistd.h>

#include <charconv>
#include <filesystem>
#include <map>

namespace berth
{

namespace
{

namespace fs = std::filesystem;

constexpr double bytes_per_MB = 1e6;

fs::path folder_of(const fs::path &log)
{
    return log.has_parent_path() ? log.parent_path() : fs::path(".");
}

/* 12 of run.12.ulg, where the log is run.ulg; else 0. */
std::uint64_t number_of(const fs::path &file, const fs::path &log)
{
    const std::string begin = log.stem().string() + ".";
    const std::string end = log.extension().string();
    const std::string name = file.filename().string();
    std::uint64_t number = 0;
    if (name.size() > begin.size() + end.size() && name.compare(0, begin.size(), begin) == 0) {
        const char *const last = name.data() + name.size() - end.size();
        const auto [behind, error] = std::from_chars(name.data() + begin.size(), last, number);
        if (error != std::errc() || behind != last || name.compare(name.size() - end.size(), end.size(), end) != 0) {
            return 0;
        }
    }
    return number;
}

std::map<std::uint64_t, fs::path> numbered_files(const fs::path &log)
{
    std::map<std::uint64_t, fs::path> files;
    std::error_code error;
    for (fs::directory_iterator file(folder_of(log), error), end; !error && file != end; file.increment(error)) {
        if (const std::uint64_t number = number_of(file->path(), log); number > 0) {
            files[number] = file->path();
        }
    }
    return files;
}

} // namespace

bool log_rotation::is_due(std::int64_t part_bytes, double part_s) const
{
    constexpr double s_per_h = 3600.0;
    return (part_MB > 0.0 && static_cast<double>(part_bytes) >= part_MB * bytes_per_MB) ||
           (part_h > 0.0 && part_s >= part_h * s_per_h);
}

bool shelve_log(const std::string &log)
{
    std::error_code error;
    if (!fs::is_regular_file(log, error)) {
        return true;
    }
    const auto files = numbered_files(log);
    const std::uint64_t number = files.empty() ? 1 : files.rbegin()->first + 1;
    fs::path to = log;
    to.replace_filename(to.stem().string() + "." + std::to_string(number) + to.extension().string());
    fs::rename(log, to, error);
    return !error;
}

void make_room(const std::string &log, const log_rotation &rotation)
{
    if (rotation.total_MB <= 0.0) {
        return;
    }
    double bytes = rotation.part_MB * bytes_per_MB;
    const auto files = numbered_files(log);
    std::error_code error;
    for (auto file = files.rbegin(); file != files.rend(); file++) {
        bytes += static_cast<double>(fs::file_size(file->second, error));
        if (bytes > rotation.total_MB * bytes_per_MB) {
            fs::remove(file->second, error);
        }
    }
}

void sync_folder_of(const std::string &log)
{
    const int folder = open(folder_of(log).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder >= 0) {
        fsync(folder);
        close(folder);
    }
}

} // namespace berth
