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
constexpr std::chrono::seconds sync_every{1}; /* what a power cut may cost */
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
    auto synced_at = std::chrono::steady_clock::now();
    while (!is_finishing_) {
        finish_wanted_.wait_for(lock, write_every);
        file_.drain();
        if (const auto now = std::chrono::steady_clock::now(); now - synced_at >= sync_every) {
            file_.sync();
            synced_at = now;
        }
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
