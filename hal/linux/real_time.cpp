#include "real_time.h"

#include <fcntl.h>
#include <malloc.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace berth
{

namespace
{

/* More than the loop's deepest call needs: 20 KB, of which most is the buffer of one reading of a bus. */
constexpr std::size_t stack_bytes = std::size_t{256} * 1024;

/* Program, log ring and the stacks of the threads beside the loop, with room to spare. */
constexpr rlim_t locked_bytes_min = rlim_t{64} * 1024 * 1024;

void prefault_stack()
{
    unsigned char stack[stack_bytes];
    explicit_bzero(stack, sizeof stack); /* no compiler leaves this out */
}

} // namespace

real_time::real_time(const target_rig &target)
{
    CPU_ZERO(&cpus_before_);
    sched_getaffinity(0, sizeof cpus_before_, &cpus_before_);
    other_cpus_ = cpus_before_;
    lock_memory();
    bind_to_cpu(target.cpu);
    keep_cpu_awake();
    schedule(target);
}

real_time::~real_time()
{
    const sched_param ordinary{};
    sched_setscheduler(0, SCHED_OTHER, &ordinary);
    sched_setaffinity(0, sizeof cpus_before_, &cpus_before_);
    munlockall();
    if (latency_file_ >= 0) {
        close(latency_file_);
    }
}

/* Without this first page the rest is worth little: a page fault may wait for a disk. */
void real_time::lock_memory()
{
    rlimit limit{};
    getrlimit(RLIMIT_MEMLOCK, &limit);
    if (geteuid() != 0 && limit.rlim_cur < locked_bytes_min) { /* what is locked now would leave none for later */
        problem_ =
            "only " + std::to_string(limit.rlim_cur) +
            " bytes of memory may be locked: raise LimitMEMLOCK (systemd) or memlock (limits.d), or run as root";
        return;
    }
    mallopt(M_TRIM_THRESHOLD, -1);
    mallopt(M_MMAP_MAX, 0);
    if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0) {
        problem_ = std::string("memory cannot be locked (") + std::strerror(errno) +
                   "): raise LimitMEMLOCK (systemd) or memlock (limits.d), or run as root";
        return;
    }
    prefault_stack();
    description_ += "memory locked";
}

void real_time::bind_to_cpu(std::int64_t cpu)
{
    if (cpu < 0) {
        return;
    }
    cpu_set_t set;
    CPU_ZERO(&set);
    if (cpu < CPU_SETSIZE) {
        CPU_SET(static_cast<std::size_t>(cpu), &set);
    }
    if (sched_setaffinity(0, sizeof set, &set) != 0) {
        problem_ = "CPU " + std::to_string(cpu) + " cannot be had (" + std::strerror(errno) +
                   "): `lscpu` lists what there is; see target.cpu";
        return;
    }
    description_ += ", CPU " + std::to_string(cpu);
    if (CPU_COUNT(&other_cpus_) > 1) {
        CPU_CLR(static_cast<std::size_t>(cpu), &other_cpus_);
    }
}

/* Held open: the CPU takes no sleep that it would be slow to wake from. Good to have, not a condition. */
void real_time::keep_cpu_awake()
{
    latency_file_ = open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC);
    const std::int32_t latency_us = 0;
    if (latency_file_ >= 0 && write(latency_file_, &latency_us, sizeof latency_us) == sizeof latency_us) {
        description_ += ", CPU latency 0 us";
    }
}

/* The CAN interrupts' threads run at 50. Above them the loop wakes on time however many frames storm in, and reads
 * what they had brought by then; below them a storm on one bus would delay every setpoint. */
void real_time::schedule(const target_rig &target)
{
    sched_param parameters{};
    parameters.sched_priority = static_cast<int>(target.priority);
    if (sched_setscheduler(0, SCHED_FIFO, &parameters) != 0) {
        problem_ = "SCHED_FIFO " + std::to_string(target.priority) + " is refused (" + std::strerror(errno) +
                   "): raise LimitRTPRIO (systemd) or rtprio (limits.d), or run as root";
        return;
    }
    description_ = "SCHED_FIFO " + std::to_string(target.priority) +
                   (description_.empty() || description_[0] == ',' ? "" : ", ") + description_;
}

} // namespace berth
