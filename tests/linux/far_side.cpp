/* The simulated rig on can2 (robot) and can3 (sensor), which are the other ends of can0 and can1. */
#include "../support/far_side.h"

#include <atomic>
#include <thread>

#include "../../hal/rig/rig_file.h"
#include "../../sim_hal/far_end/far_end.h"

namespace berth
{

struct far_side::process {
    explicit process(const rig &rig) : end(rig, {"can2", "can3", false, 400, 70}), thread([this] { end.run(stop); })
    {
    }
    ~process()
    {
        stop = true;
        thread.join();
    }

    std::atomic<bool> stop{false};
    far_end end;
    std::thread thread;
};

far_side::far_side(const std::string &rig)
{
    try {
        process_ = std::make_unique<process>(load_rig(rig));
    } catch (const input_error &) { /* no such rig: that is for the hal to say */
    }
}

far_side::~far_side() = default;

} // namespace berth
