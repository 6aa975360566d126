/* Tells systemd and /dev/watchdog that the loop is alive, as long as its ticks go on. */
#ifndef HAL_LINUX_WATCHDOG_H
#define HAL_LINUX_WATCHDOG_H

#include <sched.h>

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace berth
{

/* Where the kernel has its first watchdog. */
constexpr const char *first_watchdog = "/dev/watchdog";

/* target.watchdog_device = "auto" */
bool is_any_watchdog(const std::string &wanted);

class watchdog
{
  public:
    /* Feeds while `ticks` goes on, from a thread on `cpus`. `wanted`: a device; "auto": `any_device`, or none where
     * that cannot be opened; empty: only systemd. Throws hardware_error. */
    watchdog(const std::string &wanted, const std::atomic<std::uint64_t> &ticks, const cpu_set_t &cpus,
             const std::string &any_device = first_watchdog);

    /* Gives the device back (magic close): a clean stop must not reboot the machine. */
    ~watchdog();
    watchdog(const watchdog &) = delete;
    watchdog &operator=(const watchdog &) = delete;

  private:
    void run();
    void feed();

    const std::atomic<std::uint64_t> &ticks_;
    std::string device_;
    int file_ = -1;
    std::mutex mutex_;
    std::condition_variable finish_wanted_;
    bool is_finishing_ = false;
    std::thread thread_;
};

/* One message to systemd, as sd_notify(3): "READY=1". Nothing happens if systemd is not listening. */
void notify_systemd(const std::string &message);

} // namespace berth

#endif
