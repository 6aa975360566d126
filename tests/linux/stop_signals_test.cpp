/* Which signals end a loop in order: in a process of its own, since none of them is ever taken back. */
#include "../../hal/linux/stop_signals.h"

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <doctest/doctest.h>
#include <initializer_list>

namespace berth
{

namespace
{

enum : int { goes_on = 10, stops_in_order = 11 };

/* What a process does when it gets `signal`: an exit code of the above, or the signal that has killed it, negative.
 */
int after(int signal, bool is_ignored)
{
    const pid_t child = fork();
    if (child == 0) {
        std::signal(signal, is_ignored ? SIG_IGN : SIG_DFL);
        catch_stop_signals();
        std::raise(signal);
        _exit(stop_is_wanted() ? stops_in_order : goes_on);
    }
    int status = 0;
    REQUIRE(waitpid(child, &status, 0) == child);
    return WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
}

} // namespace

TEST_CASE("signals: a wish to stop and the end of a terminal stop in order, a broken pipe does not")
{
    for (const int signal : {SIGTERM, SIGINT, SIGHUP}) {
        CAPTURE(signal);
        CHECK(after(signal, false) == stops_in_order);
    }
    CHECK(after(SIGHUP, true) == goes_on); /* nohup */
    CHECK(after(SIGPIPE, false) == goes_on);
    CHECK(after(SIGXFSZ, false) == goes_on);
    CHECK(after(SIGKILL, false) == -SIGKILL);
}

} // namespace berth
