#include "stop_signals.h"

#include <csignal>

namespace
{

volatile std::sig_atomic_t stop_signal = 0;

extern "C" void on_stop_signal(int signal)
{
    stop_signal = signal;
}

} // namespace

namespace berth
{

void catch_stop_signals()
{
    struct sigaction action = {};
    action.sa_handler = on_stop_signal;
    sigaction(SIGTERM, &action, nullptr);
    sigaction(SIGINT, &action, nullptr);
    struct sigaction before = {};
    sigaction(SIGHUP, nullptr, &before);
    if (before.sa_handler != SIG_IGN) { /* nohup wants it to go on */
        sigaction(SIGHUP, &action, nullptr);
    }
    std::signal(SIGXFSZ, SIG_IGN); /* a file size limit is a full disk */
    std::signal(SIGPIPE, SIG_IGN);
}

bool stop_is_wanted()
{
    return stop_signal != 0;
}

} // namespace berth
