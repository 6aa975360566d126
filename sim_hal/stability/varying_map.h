/* Growth of a loop that changes from tick to tick over two parameters of a rig. All points go along the same seeded
 * sequence, so that the limit of stability is a smooth line. */
#ifndef SIM_HAL_STABILITY_VARYING_MAP_H
#define SIM_HAL_STABILITY_VARYING_MAP_H

#include <functional>
#include <vector>

#include "../hil/wake_histogram.h"
#include "stability_map.h"

namespace berth
{

/* Lyapunov exponents in 1/s: rows of y, in each all x; NaN where there is no value. The same bits whatever the
 * number of threads. `rows_done` is called now and then from the calling thread. */
std::vector<double> compute_varying_map(const map_request &request, const wake_histogram &histogram,
                                        std::int64_t ticks, int threads,
                                        const std::function<void(int)> &rows_done = {});

} // namespace berth

#endif
