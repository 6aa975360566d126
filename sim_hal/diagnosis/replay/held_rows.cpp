#include "held_rows.h"

#include <algorithm>
#include <cmath>

namespace berth
{

namespace
{

constexpr double noise_most = 4.0;     /* standard deviations: no force */
constexpr double force_least = 3.0;    /* the same, rms over the rows: one that ought to be there */
constexpr double loose_least_s = 0.02; /* a force that passes zero is shorter there */
constexpr double held_least_s = 0.25;  /* between one time loose and the next: less is bouncing */
constexpr double before_s = 0.02;      /* that it gives way, until the low-pass shows no force */
constexpr double settles = 5.0;        /* time constants of the sensor's spring, once the object is caught */
constexpr double settles_most_s = 0.5;

/* White noise as large as second differences say: the motion is slow from row to row. */
double noise_of_rows(const std::vector<double> &force_N)
{
    std::vector<double> second;
    for (std::size_t n = 2; n < force_N.size(); n++) {
        second.push_back(std::abs(force_N[n] - 2.0 * force_N[n - 1] + force_N[n - 2]));
    }
    constexpr double median_of_normal = 0.6745;
    return median_of(std::move(second)) / (median_of_normal * std::sqrt(6.0));
}

} // namespace

std::optional<std::vector<row_use>> uses_while_held(block_model &model, const rig &rig)
{
    constexpr double few = 0.01; /* of the rows */
    const std::vector<double> &force_N = model.measured();
    const double noise_N = noise_of_rows(force_N);
    const auto rows_of = [&](double time_s) {
        return static_cast<std::size_t>(std::ceil(time_s / model.data().period_s));
    };
    const double time_constant_s = 2.0 * rig.object.mass_kg / std::max(rig.sensor_damping_N_s_per_m(), 1e-9);
    const std::size_t settling =
        rows_of(std::min(settles * time_constant_s + rig.sensor_low_pass_delay_s(), settles_most_s));
    std::vector<double> error;
    model.error(rig, error);
    std::vector<row_use> uses = model.uses();
    std::size_t loose = 0;
    std::size_t settled = 0; /* the row at which it has, after it was caught last */
    for (std::size_t begin = 0; begin < force_N.size();) {
        std::size_t end = begin;
        double expected = 0.0;
        while (end < force_N.size() && std::abs(force_N[end]) < noise_most * noise_N) {
            expected += std::pow(force_N[end] - error[end], 2);
            end++;
        }
        const std::size_t length = end - begin;
        if (length >= rows_of(loose_least_s) &&
            std::sqrt(expected / static_cast<double>(length)) > force_least * noise_N) {
            const std::size_t gave_way = begin - std::min(begin, rows_of(before_s));
            const bool bounces = loose > 0 && gave_way < settled + rows_of(held_least_s);
            const std::size_t from = bounces ? std::min(settled, gave_way) : gave_way;
            settled = std::min(force_N.size(), end + settling);
            std::fill(uses.begin() + static_cast<std::ptrdiff_t>(from),
                      uses.begin() + static_cast<std::ptrdiff_t>(settled), row_use::none);
            loose += length;
        }
        begin = std::max(end, begin + 1);
    }
    const bool any = static_cast<double>(loose) > few * static_cast<double>(force_N.size());
    return any ? std::optional(std::move(uses)) : std::nullopt;
}

} // namespace berth
