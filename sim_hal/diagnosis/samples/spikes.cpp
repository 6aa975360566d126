#include "spikes.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "../noise/lattice_step.h"

namespace berth
{

namespace
{

constexpr double known_far_sd = 5.6;       /* of spikes as large as others that are surely some */
constexpr std::size_t stop_rows_min = 20;  /* that stay at the largest or the smallest value: it is a limit */
constexpr double sigma_of_median = 1.4826; /* of the sizes of a normal noise */

/* Where the force itself changes as much, as on first touch, an instant that is a little wrong looks like a spike.
 */
bool is_calm(const std::vector<double> &force_N, std::size_t n, double off_N)
{
    return std::abs(force_N[n + 1] - force_N[n - 1]) < std::abs(off_N);
}

/* On how many sides of row n the neighbour sees half of what is off: of the sample itself, where its neighbours see
 * half of it each; of a step, which has a second half, on none. */
int spike_sides(const std::vector<double> &off, std::size_t n)
{
    const auto is_half = [&](double neighbour) { return std::abs(neighbour / off[n] + 0.5) < 0.25; };
    return is_half(off[n - 1]) + is_half(off[n + 1]);
}

/* At its end of range, or with steps above the noise, a sensor tells nothing of the noise. */
bool stands_still(const std::vector<double> &force_N, std::size_t n)
{
    return force_N[n - 1] == force_N[n] && force_N[n + 1] == force_N[n];
}

/* The rows of a record without those that only repeat a sample: where one was dropped after a spike, the spike's
 * neighbour is farther away. */
struct own_samples {
    std::vector<std::size_t> row;
    std::vector<double> error;
    std::vector<double> force_N;
    std::vector<std::uint8_t> is_known;
};

own_samples samples_of(const block_model &model, const std::vector<double> &error, const sample_events &events)
{
    own_samples made;
    for (std::size_t n = 0; n < error.size(); n++) {
        if (events.force_repeats.empty() || events.force_repeats[n] == 0) {
            made.row.push_back(n);
            made.error.push_back(error[n]);
            made.force_N.push_back(model.data().force_N[n]);
            made.is_known.push_back(model.uses()[n] != row_use::none);
        }
    }
    return made;
}

/* Chance strikes all over the record; what comes in a few bursts has a cause there. */
bool are_scattered(const std::vector<std::uint8_t> &rows)
{
    constexpr std::size_t near = 10; /* rows */
    constexpr double share = 0.5;    /* of the groups that chance makes */
    std::size_t count = 0;
    std::size_t groups = 0;
    std::size_t last = 0;
    for (std::size_t n = 0; n < rows.size(); n++) {
        if (rows[n] != 0) {
            groups += count == 0 || n - last > near;
            count++;
            last = n;
        }
    }
    const double often = static_cast<double>(count) / static_cast<double>(rows.size());
    return static_cast<double>(groups) >
           share * static_cast<double>(count) * std::exp(-often * static_cast<double>(near));
}

/* The noise about each sample, of how far those within a quarter of a second are off. What grows with the motion, as
 * what the steps of a coarse command leave open, is loud there and no spike for being quiet where the robot rests.
 */
std::vector<double> sigma_about(const std::vector<double> &off)
{
    constexpr std::size_t stretch = 64; /* samples */
    std::vector<double> of_stretch;
    for (std::size_t begin = 0; begin < off.size(); begin += stretch) {
        std::vector<double> sizes;
        for (std::size_t n = begin; n < std::min(begin + stretch, off.size()); n++) {
            if (off[n] != 0.0) {
                sizes.push_back(std::abs(off[n]));
            }
        }
        of_stretch.push_back(sizes.empty() ? 0.0 : sigma_of_median * median_of(std::move(sizes)));
    }
    std::vector<double> sigma(off.size());
    for (std::size_t n = 0; n < off.size(); n++) {
        const std::size_t at = n / stretch;
        sigma[n] = std::max({of_stretch[at], at > 0 ? of_stretch[at - 1] : 0.0,
                             at + 1 < of_stretch.size() ? of_stretch[at + 1] : 0.0});
    }
    return sigma;
}

/* Share of normal noise that is off by more. */
double beyond(double sd)
{
    return std::erfc(sd / std::sqrt(2.0));
}

class spike_finder
{
  public:
    spike_finder(const block_model &model, const std::vector<double> &error, const sample_events &events)
        : rows(error.size(), 0), of_(samples_of(model, error, events)), off_(of_.error.size(), 0.0)
    {
        std::vector<double> sizes;
        for (std::size_t n = 2; n + 2 < off_.size(); n++) {
            if (!of_.is_known[n - 1] || !of_.is_known[n] || !of_.is_known[n + 1]) {
                continue;
            }
            off_[n] = of_.error[n] - 0.5 * (of_.error[n - 1] + of_.error[n + 1]);
            if (!stands_still(of_.force_N, n)) {
                sizes.push_back(std::abs(off_[n]));
            }
        }
        tried = sizes.size();
        const auto [least, largest] = std::minmax_element(of_.force_N.begin(), of_.force_N.end());
        least_force_N_ = *least;
        largest_force_N_ = *largest;
        const auto is_stop = [&](double value_N) {
            std::size_t held = 0;
            for (std::size_t n = 1; n < of_.force_N.size(); n++) {
                held += of_.force_N[n - 1] == value_N && of_.force_N[n] == value_N;
            }
            return held >= stop_rows_min;
        };
        stops_at_least_ = is_stop(least_force_N_);
        stops_at_largest_ = is_stop(largest_force_N_);
        sigma_N = sigma_of_median * median_of(sizes);
        sigma_about_N_ = sigma_about(off_);
        far_N_ = std::max(spike_far_sd * sigma_N, 2.0 * lattice_step(model.data().known(model.data().force_N)));
    }

    /* Between neighbours that see half of it each. */
    void find_alone()
    {
        for (std::size_t n = 2; n + 2 < off_.size(); n++) {
            if (is_far(n) && is_alone(n)) {
                add(n, std::abs(off_[n]));
                far_sd_.push_back(far_sd(n));
                around_sd_.push_back(sd_around(n));
            }
        }
    }

    /* Spikes are apart from the noise. Of a noise whose own size has long tails many samples are off by half of what
     * passes for a spike; of one that is loud for a few rows those around are off, too. */
    bool are_apart()
    {
        constexpr double from = 0.5; /* of what all but a tenth of the spikes are off */
        constexpr double to = 0.7;
        constexpr double as_many = 0.5; /* of 8 rows in a burst 0.8, of Student's t with 3 degrees of freedom 5 */
        constexpr double loud = 1.3;    /* among the rows around: of noise 0.7 */
        if (median_of(around_sd_) > loud) {
            return false;
        }
        std::sort(far_sd_.begin(), far_sd_.end());
        const double least = far_sd_[far_sd_.size() / 10];
        std::size_t between = 0;
        for (std::size_t n = 2; n + 2 < off_.size(); n++) {
            const bool is_beside_one =
                rows[of_.row[n - 1]] != 0 || rows[of_.row[n]] != 0 || rows[of_.row[n + 1]] != 0;
            const double sd = far_sd(n);
            between += sd > from * least && sd < to * least && !is_beside_one && is_alone(n);
        }
        const double by_chance = static_cast<double>(tried) * (beyond(from * least) - beyond(to * least));
        return static_cast<double>(between) <=
               as_many * static_cast<double>(far_sd_.size()) + by_chance + 2.0 * std::sqrt(by_chance);
    }

    /* Once spikes are known, those as large are some too: two samples apart, where two hide each other's half, and
     * right after each other. */
    void find_close()
    {
        const auto [least, largest] = std::minmax_element(amplitudes.begin(), amplitudes.end());
        least_N_ = std::max(known_far_sd / spike_far_sd * far_N_, *least - 4.0 * sigma_N);
        largest_N_ = *largest + 4.0 * sigma_N;
        for (std::size_t n = 2; n + 2 < off_.size(); n++) {
            const double size_N = std::abs(off_[n]);
            const bool is_level = std::abs(of_.error[n + 1] - of_.error[n - 1]) < 0.25 * size_N;
            const int sides = spike_sides(off_, n);
            if (rows[of_.row[n]] == 0 && is_as_large(size_N) && !is_held(n) && far_sd(n) > known_far_sd &&
                is_calm(of_.force_N, n, off_[n]) && (sides == 2 || (sides == 1 && is_level))) {
                add(n, size_N);
            }
        }
        for (std::size_t n = 2; n + 3 < off_.size(); n++) {
            find_two_at(n);
        }
    }

    std::vector<std::uint8_t> rows;
    std::vector<double> amplitudes;
    std::size_t tried; /* samples that would have shown one */
    double sigma_N;

  private:
    void add(std::size_t n, double size_N)
    {
        rows[of_.row[n]] = 1;
        amplitudes.push_back(size_N);
    }

    /* A sample that did not come, or that stopped at the end of the range, is as far off on a way that turns there.
     */
    bool is_held(std::size_t n) const
    {
        return of_.force_N[n] == of_.force_N[n - 1] || (stops_at_least_ && of_.force_N[n] == least_force_N_) ||
               (stops_at_largest_ && of_.force_N[n] == largest_force_N_);
    }

    bool is_far(std::size_t n) const
    {
        return std::abs(off_[n]) > std::max(far_N_, spike_far_sd * sigma_about_N_[n]);
    }

    bool is_alone(std::size_t n) const
    {
        return is_calm(of_.force_N, n, off_[n]) && spike_sides(off_, n) == 2 && !is_held(n);
    }

    /* How far the samples around are off, beyond those that see half of it. */
    double sd_around(std::size_t n) const
    {
        constexpr std::size_t reach = 4;
        std::vector<double> all;
        for (std::size_t k = 2; k <= reach; k++) {
            all.push_back(n >= k ? far_sd(n - k) : 0.0);
            all.push_back(n + k < off_.size() ? far_sd(n + k) : 0.0);
        }
        return median_of(std::move(all));
    }

    double far_sd(std::size_t n) const { return std::abs(off_[n]) / std::max(sigma_N, sigma_about_N_[n]); }

    bool is_as_large(double size_N) const { return size_N > least_N_ && size_N < largest_N_; }

    void find_two_at(std::size_t n)
    {
        const std::vector<double> &error = of_.error;
        const auto is_free = [&](std::size_t k) { return of_.is_known[k] && rows[of_.row[k]] == 0; };
        if (!is_free(n - 1) || !is_free(n) || !is_free(n + 1) || !is_free(n + 2)) {
            return;
        }
        const double before_N = (2.0 * error[n - 1] + error[n + 2]) / 3.0;
        const double after_N = (error[n - 1] + 2.0 * error[n + 2]) / 3.0;
        const double first_N = std::abs(error[n] - before_N);
        const double second_N = std::abs(error[n + 1] - after_N);
        const double outside_N =
            std::max(std::abs(error[n + 2] - error[n - 1]), std::abs(of_.force_N[n + 2] - of_.force_N[n - 1]));
        if (is_as_large(first_N) && is_as_large(second_N) && outside_N < 0.25 * std::min(first_N, second_N)) {
            add(n, first_N);
            add(n + 1, second_N);
        }
    }

    own_samples of_;
    std::vector<double> off_; /* of each sample from the middle of its neighbours */
    std::vector<double> sigma_about_N_;
    std::vector<double> far_sd_;    /* of those found alone, by how many sigma they are off */
    std::vector<double> around_sd_; /* the same of the samples around them */
    double far_N_;
    double least_force_N_;
    double largest_force_N_;
    bool stops_at_least_;
    bool stops_at_largest_;
    double least_N_ = 0.0;
    double largest_N_ = 0.0;
};

} // namespace

std::vector<event_finding> find_spikes(const block_model &model, const std::vector<double> &error,
                                       sample_events &events, spikes_wanted wanted)
{
    spike_finder of(model, error, events);
    of.find_alone();
    if (of.amplitudes.size() < events_min || !of.are_apart()) {
        return {};
    }
    of.find_close();
    if (of.amplitudes.size() * 10 > of.tried || !are_scattered(of.rows)) {
        return {};
    }
    const double count = static_cast<double>(of.amplitudes.size());
    const double mean_N = std::accumulate(of.amplitudes.begin(), of.amplitudes.end(), 0.0) / count;
    double variance = 0.0;
    for (const double amplitude_N : of.amplitudes) {
        variance += std::pow(amplitude_N - mean_N, 2) / count;
    }
    constexpr double of_noise = 4.0; /* times the variance that the noise gives to sizes that are the same */
    constexpr double of_mean = 0.2;
    if (wanted == spikes_wanted::of_one_size &&
        variance > of_noise * of.sigma_N * of.sigma_N + of_mean * of_mean * mean_N * mean_N) {
        return {};
    }
    events.spike = of.rows;
    event_finding found = found_in("sensor.spikes", of.amplitudes.size(), of.tried);
    found.values.push_back(mean_N);
    found.ci95.push_back(1.96 * std::sqrt((variance + of.sigma_N * of.sigma_N) / count));
    return {found};
}

} // namespace berth
