/* Brings the log to the disk in a thread of its own, at normal priority: the loop never waits for a disk. A power
 * cut costs the last second. */
#ifndef HAL_LINUX_LOG_WRITER_H
#define HAL_LINUX_LOG_WRITER_H

#include <sched.h>

#include <condition_variable>
#include <mutex>
#include <thread>

#include "../log_file.h"
#include "log_rotation.h"

namespace berth
{

class log_writer
{
  public:
    /* Throws input_error if the file cannot be made. Its thread runs on `cpus`. With a rotation, a file of this name
     * that is there stays, with a number. `witness`: sees the records, in this thread; may be empty. */
    log_writer(const std::string &path, const log_header &header, const cpu_set_t &cpus,
               const log_rotation &rotation = {}, log_file::witness witness = {});
    ~log_writer();

    /* For the loop. */
    bool push(const void *bytes, std::size_t size_bytes) { return file_.push(bytes, size_bytes); }

    /* Writes what is left and ends the thread. */
    void finish();

    const log_file &file() const { return file_; } /* after finish() */

  private:
    void run();
    void begin_part();

    std::string path_;
    log_header header_;
    log_rotation rotation_;
    int part_ = 1;
    log_file file_;
    std::mutex mutex_;
    std::condition_variable finish_wanted_;
    bool is_finishing_ = false;
    std::thread thread_;
};

} // namespace berth

#endif
