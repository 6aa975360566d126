/* Files that people give where a rig file belongs: what they are, and where they go. */
#ifndef HAL_RIG_OTHER_FILES_H
#define HAL_RIG_OTHER_FILES_H

#include <string>

namespace berth
{

/* By the bytes of the file. Throws input_error; returns where it may be text of a rig file. */
void refuse_other_file(const std::string &path, const std::string &bytes);

} // namespace berth

#endif
