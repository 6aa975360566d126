#include "log_writer.h"

#include <chrono>

#include "thread.h"

namespace berth
{

namespace
{
/* At 400 Hz and 330 bytes a tick the ring bridges half a minute of a disk that does not answer. */
constexpr std::size_t ring_bytes = std::size_t{1} << 22;
constexpr std::chrono::milliseconds write_every{50};
} // namespace

log_writer::log_writer(const std::string &path, const log_header &header, const cpu_set_t &cpus)
    : file_(path, header, ring_bytes), thread_(start_thread("log", cpus, [this] { run(); }))
{
}

log_writer::~log_writer()
{
    finish();
}

void log_writer::run()
{
    std::unique_lock<std::mutex> lock(mutex_);
    while (!is_finishing_) {
        finish_wanted_.wait_for(lock, write_every);
        file_.drain();
    }
}

void log_writer::finish()
{
    if (!thread_.joinable()) {
        return;
    }
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        is_finishing_ = true;
    }
    finish_wanted_.notify_one();
    thread_.join();
    file_.drain();
}

} // namespace berth
