/* SIGTERM, SIGINT and the end of a terminal (SIGHUP, unless nohup) ask for an orderly stop: the robot is led to rest
 * first. A disk or a reader that has gone away is no reason to end a loop: write() says so. */
#ifndef HAL_LINUX_STOP_SIGNALS_H
#define HAL_LINUX_STOP_SIGNALS_H

namespace berth
{

void catch_stop_signals();

/* One has come since the start of the program. */
bool stop_is_wanted();

} // namespace berth

#endif
