/* Growth of a loop that has no eigenvalues, such as one with a passivity controller: at each point of a map firmware
 * and simulated rig run, and how their swing grows is measured. It depends on how far the swing goes. */
#ifndef SIM_HAL_COMPENSATION_MEASURED_MAP_H
#define SIM_HAL_COMPENSATION_MEASURED_MAP_H

#include <functional>
#include <vector>

#include "../stability/stability_map.h"
#include "trial.h"

namespace berth
{

/* Where the manipulator is at rest without a force. */
double rest_m(const rig &rig);

/* The rig as it is run: let go at the amplitude (of the request, or its own, or 10 mm), and nothing else asked of
 * it. */
rig released_rig(const rig &rig, double amplitude_m);

/* Of several models that the loop may be told: the worst of each. */
struct measured_point {
    double growth_per_s;
    double error; /* distance to the motion without dead time, as a share of its swing */
    berth::fate fate;
    bool is_faulted = false; /* a fault ended it before it grew; its growth is one over the run's length then */
};

/* Runs one rig; throws input_error if it cannot be. */
measured_point measure(const rig &rig, double duration_s);

/* Rows of y, in each all x; NaN where there is no value. The same bits whatever the number of threads. `rows_done`
 * is called now and then from the calling thread. `request.rig` as released_rig() makes it. */
std::vector<measured_point> compute_measured_map(const map_request &request, double duration_s, int threads,
                                                 const std::function<void(int)> &rows_done = {});

} // namespace berth

#endif
