#include "unreadable.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace berth
{

bool is_folder(const std::string &path)
{
    struct stat found = {};
    return stat(path.c_str(), &found) == 0 && S_ISDIR(found.st_mode);
}

namespace
{

std::string reason(const std::string &path)
{
    if (is_folder(path)) {
        return "it is a folder; name a file in it";
    }
    if (access(path.c_str(), R_OK) == 0) {
        return "is it a file?";
    }
    if (errno != ENOENT && errno != ENOTDIR) {
        return std::strerror(errno);
    }
    const std::size_t slash = path.rfind('/');
    const std::string folder = slash == std::string::npos ? "" : path.substr(0, slash);
    return folder.empty() || is_folder(folder) ? "there is no such file" : "there is no folder " + folder;
}

} // namespace

std::string unreadable(const std::string &path)
{
    return path + ": cannot be read: " + reason(path);
}

} // namespace berth
