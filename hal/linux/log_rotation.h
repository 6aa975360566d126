/* A long run's log is a row of files: LOG is written now, STEM.1.ulg, STEM.2.ulg and so on came before it, of this
 * run and of earlier ones. The oldest ones go where all of them would take too much room. */
#ifndef HAL_LINUX_LOG_ROTATION_H
#define HAL_LINUX_LOG_ROTATION_H

#include <cstdint>
#include <string>

namespace berth
{

/* 0: no limit. */
struct log_rotation {
    double part_MB = 0.0;
    double part_h = 0.0;
    double total_MB = 0.0; /* the file that is written now included */

    bool is_on() const { return part_MB > 0.0 || part_h > 0.0; }
    bool is_due(std::int64_t part_bytes, double part_s) const;
};

/* Gives the file the next number, if there is one of this name. False: it cannot be renamed. */
bool shelve_log(const std::string &log);

/* Removes files with the smallest numbers until there is room for one more part. */
void make_room(const std::string &log, const log_rotation &rotation);

/* So that a power cut leaves the names as they are now. */
void sync_folder_of(const std::string &log);

} // namespace berth

#endif
