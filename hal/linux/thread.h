/* Threads beside the loop: normal priority, not on the loop's CPU, no signals (those are the loop's). */
#ifndef HAL_LINUX_THREAD_H
#define HAL_LINUX_THREAD_H

#include <pthread.h>
#include <sched.h>

#include <csignal>
#include <thread>
#include <utility>

namespace berth
{

/* A new thread inherits what its parent is: here that would be the loop's scheduling. */
inline void become_ordinary(const cpu_set_t &cpus)
{
    const sched_param parameters{};
    sched_setscheduler(0, SCHED_OTHER, &parameters);
    sched_setaffinity(0, sizeof cpus, &cpus);
}

template <typename callable>
std::thread start_thread(const char *name, const cpu_set_t &cpus, callable run)
{
    sigset_t all;
    sigset_t before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    std::thread thread([cpus, run = std::move(run)] {
        become_ordinary(cpus);
        run();
    });
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    pthread_setname_np(thread.native_handle(), name);
    return thread;
}

} // namespace berth

#endif
