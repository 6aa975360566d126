/* Which setpoints were lost, decided one after the other along the record. */
#ifndef SIM_HAL_DIAGNOSIS_SAMPLES_LOSS_DECODER_H
#define SIM_HAL_DIAGNOSIS_SAMPLES_LOSS_DECODER_H

#include <cstdint>
#include <optional>
#include <vector>

#include "../replay/driven_path.h"
#include "loss_settler.h"

namespace berth
{

struct decoded_losses {
    std::vector<std::uint8_t> lost; /* a row each */
    std::vector<double> rest;       /* what is left of the error */
};

/* Of a setpoint that was lost or not only the rows after it tell; so of all that may have happened up to it the
 * likeliest few histories are kept, and of these the best at the end (the M-algorithm of sequential decoding). That
 * tells losses apart whose traces ring into each other.
 * `error`: of a replay in which none was lost, of which the rows in `counts` are compared (1 or 0); `penalty`:
 * squares that a loss has to explain; `path`: what the robot makes of the setpoints at the first of them; `loss` is
 * of what comes after it. Nothing as soon as all that is kept leaves more than `square_max`: that can only grow.
 * Without a penalty histories which differ by losses that hardly show crowd out others. */
std::optional<decoded_losses> decode_losses(const std::vector<double> &sent, const driven_path &path,
                                            const loss_trace &loss, const std::vector<double> &error,
                                            const std::vector<double> &counts, double penalty, double square_max);

} // namespace berth

#endif
