/* Why a file cannot be read. */
#ifndef HAL_RIG_UNREADABLE_H
#define HAL_RIG_UNREADABLE_H

#include <string>

namespace berth
{

bool is_folder(const std::string &path);

/* "PATH: cannot be read: there is no such file", or that its folder does not exist, that it is a folder, or what the
 * system says. */
std::string unreadable(const std::string &path);

} // namespace berth

#endif
