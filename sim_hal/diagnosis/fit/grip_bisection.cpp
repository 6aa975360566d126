#include "grip_bisection.h"

#include <cmath>

namespace berth
{

namespace
{

constexpr double wrong_sd = 7.0; /* times the noise; in two rows one after the other */

/* The first row that is wrong; the error's size where none is. */
std::size_t first_wrong(const std::vector<double> &error, const std::vector<row_use> &uses, double far_N)
{
    for (std::size_t n = 0; n + 1 < error.size(); n++) {
        const bool are_used = uses[n] != row_use::none && uses[n + 1] != row_use::none;
        if (are_used && std::abs(error[n]) > far_N && std::abs(error[n + 1]) > far_N &&
            error[n] * error[n + 1] > 0.0) {
            return n;
        }
    }
    return error.size();
}

} // namespace

rig with_bisected_grip(block_model &model, const noise_model &noise, rig held, std::string_view size_key,
                       double most_N)
{
    constexpr double exact = 1e-6; /* of the size */
    double low_N = 0.0;
    double high_N = most_N;
    double best_N = most_N;
    std::size_t longest = 0;
    std::vector<double> error;
    while (high_N - low_N > exact * most_N) {
        const double middle_N = 0.5 * (low_N + high_N);
        set_number(held, size_key, middle_N);
        model.error(held, error);
        const std::size_t row = first_wrong(error, model.uses(), wrong_sd * noise.rms);
        if (row >= longest) {
            longest = row;
            best_N = middle_N;
        }
        if (row == error.size()) {
            break;
        }
        const bool is_too_strong = error[row] > 0.0; /* a pull is negative: measured less simulated */
        (is_too_strong ? high_N : low_N) = middle_N;
    }
    set_number(held, size_key, best_N);
    return held;
}

} // namespace berth
