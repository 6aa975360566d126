/* What makes Linux keep time for one thread: SCHED_FIFO, memory that stays, a CPU that neither moves nor sleeps. */
#ifndef HAL_LINUX_REAL_TIME_H
#define HAL_LINUX_REAL_TIME_H

#include <sched.h>

#include <string>

#include "../rig/rig.h"

namespace berth
{

/* Applies to the calling thread until the object goes. What is refused is said in problem(); the loop then runs
 * without it. */
class real_time
{
  public:
    explicit real_time(const target_rig &target);
    ~real_time();
    real_time(const real_time &) = delete;
    real_time &operator=(const real_time &) = delete;

    bool is_real_time() const { return problem_.empty(); }
    const std::string &problem() const { return problem_; } /* empty, or what was refused and what to do */

    /* For the log: "SCHED_FIFO 80, memory locked, CPU 1, CPU latency 0 us" */
    const std::string &description() const { return description_; }

    /* For the other threads: where the process may run, without the loop's CPU unless there is no other. */
    const cpu_set_t &other_cpus() const { return other_cpus_; }

  private:
    void schedule(const target_rig &target);
    void lock_memory();
    void bind_to_cpu(std::int64_t cpu);
    void keep_cpu_awake();

    int latency_file_ = -1;
    cpu_set_t cpus_before_;
    cpu_set_t other_cpus_;
    std::string problem_;
    std::string description_;
};

} // namespace berth

#endif
