#include "drifting_clock.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

namespace berth
{

namespace
{

/* Parts of the record: a slip within one is known by the mean of its two sides only, and may come in the middle of
 * a fast move, where it weighs most. */
constexpr double part_s = 0.02;

/* How late the robot was over time, from error = -late velocity, in parts of the record that weigh by the square of
 * the velocity; as sums from the start, so that what a sawtooth leaves costs as much as it has teeth. */
class lateness_over_time
{
  public:
    lateness_over_time(const std::vector<double> &error, const std::vector<double> &position_m, double period_s)
        : length_(std::max<std::size_t>(4, static_cast<std::size_t>(part_s / period_s))), period_s_(period_s)
    {
        sums_.push_back({});
        for (std::size_t begin = 1; begin + length_ < error.size(); begin += length_) {
            double both = 0.0;
            double square = 0.0;
            for (std::size_t n = begin; n < begin + length_; n++) {
                const double velocity = (position_m[n + 1] - position_m[n - 1]) / (2.0 * period_s);
                both -= error[n] * velocity;
                square += velocity * velocity;
            }
            const double late_s = square > 0.0 ? both / square : 0.0;
            const double time_s = time_of(sums_.size() - 1);
            const sums &last = sums_.back();
            sums_.push_back({last.weight + square, last.late + square * late_s, last.time + square * time_s});
            late_squared_ += square * late_s * late_s;
            late_by_time_ += square * late_s * time_s;
            time_squared_ += square * time_s * time_s;
        }
    }

    bool is_empty() const { return !(sums_.back().weight > 0.0); }

    /* Weighted square of what a sawtooth leaves; its mean is free, as the dead time is. */
    double left_by(double drift, double phase_s) const
    {
        const sums &all = sums_.back();
        /* Of the lateness less the drift, and then less phase - k T within tooth k. */
        double sum = all.late - drift * all.time;
        double square = late_squared_ - drift * (2.0 * late_by_time_ - drift * time_squared_);
        std::size_t begin = 0;
        double tooth = std::floor((phase_s + drift * time_of(0)) / period_s_);
        while (begin + 1 < sums_.size()) {
            const std::size_t end = end_of_tooth(begin, tooth, drift, phase_s);
            const double weight = sums_[end].weight - sums_[begin].weight;
            const double late = sums_[end].late - sums_[begin].late;
            const double time = sums_[end].time - sums_[begin].time;
            const double offset_s = phase_s - tooth * period_s_;
            sum -= offset_s * weight;
            square += offset_s * (offset_s * weight - 2.0 * (late - drift * time));
            tooth += drift > 0.0 ? 1.0 : -1.0;
            begin = end;
        }
        return square - sum * sum / all.weight;
    }

  private:
    struct sums {
        double weight = 0.0;
        double late = 0.0; /* times weight */
        double time = 0.0;
    };

    double time_of(std::size_t part) const
    {
        return period_s_ * (1.0 + static_cast<double>(length_) * (static_cast<double>(part) + 0.5));
    }

    /* The first part whose middle is in the next one. */
    std::size_t end_of_tooth(std::size_t begin, double tooth, double drift, double phase_s) const
    {
        const std::size_t count = sums_.size() - 1;
        if (drift == 0.0) {
            return count;
        }
        const double slip_s = ((drift > 0.0 ? tooth + 1.0 : tooth) * period_s_ - phase_s) / drift;
        const double part = (slip_s / period_s_ - 1.0) / static_cast<double>(length_) - 0.5;
        return part < static_cast<double>(count)
                   ? std::max(begin, static_cast<std::size_t>(std::max(0.0, std::ceil(part))))
                   : count;
    }

    std::size_t length_; /* rows in a part */
    double period_s_;
    std::vector<sums> sums_;
    double late_squared_ = 0.0;
    double late_by_time_ = 0.0;
    double time_squared_ = 0.0;
};

/* A sawtooth: how many periods it drifts over the record, and which share of the way to its first slip it has behind
 * it at the start. Of a slow one, that slips once or never, the share is of the way that it goes in the record. */
struct sawtooth {
    double wraps;
    double share; /* above 1, of a slow one: no slip */
    double left = unlimited;
};

clock_guess guess_of(const sawtooth &tooth, double duration_s, double period_s)
{
    const double way = std::min(1.0, std::abs(tooth.wraps)) * tooth.share;
    const double phase = tooth.wraps > 0.0 ? 1.0 - way : way;
    return {1e6 * tooth.wraps * period_s / duration_s, 1e3 * period_s * (phase - std::floor(phase))};
}

/* Halves its steps where no neighbour is better. */
void refine(sawtooth &tooth, double wraps_step, double share_step,
            const std::function<double(const sawtooth &)> &left)
{
    constexpr int rounds = 16;
    for (int round = 0; round < rounds; round++) {
        const sawtooth here = tooth;
        for (const auto &[wraps, share] :
             {std::pair{wraps_step, 0.0}, {-wraps_step, 0.0}, {0.0, share_step}, {0.0, -share_step}}) {
            sawtooth tried{here.wraps + wraps, here.share + share};
            tried.left = left(tried);
            if (tried.left < tooth.left) {
                tooth = tried;
            }
        }
        if (tooth.left == here.left) {
            wraps_step *= 0.5;
            share_step *= 0.5;
        }
    }
}

} // namespace

std::vector<clock_guess> drifting_clocks(const std::vector<double> &error, const std::vector<double> &position_m,
                                         double period_s, int count)
{
    constexpr int wraps_max = 30; /* of the sawtooth over the record, either way */
    constexpr int steps_a_wrap = 8;
    constexpr std::size_t refined = 24;
    const lateness_over_time lateness(error, position_m, period_s);
    if (lateness.is_empty()) {
        return {};
    }
    const double duration_s = period_s * static_cast<double>(error.size());
    const auto left = [&](const sawtooth &tooth) {
        const clock_guess guess = guess_of(tooth, duration_s, period_s);
        return lateness.left_by(1e-6 * guess.drift_ppm, 1e-3 * guess.phase_ms);
    };
    /* Of a tooth: where a slip is has to be right to two parts. */
    const auto shares_of = [&](double wraps) {
        return std::max(16, static_cast<int>(duration_s / std::max(1.0, std::abs(wraps)) / (2.0 * part_s)));
    };
    std::vector<double> sizes = {1.0 / 64.0, 1.0 / 32.0, 1.0 / 16.0};
    for (int i = 1; i <= wraps_max * steps_a_wrap; i++) {
        sizes.push_back(static_cast<double>(i) / steps_a_wrap);
    }
    std::vector<sawtooth> trials;
    trials.reserve(2 * sizes.size());
    for (const double size : sizes) {
        for (const double wraps : {-size, size}) {
            sawtooth best{wraps, 0.0};
            const int shares = shares_of(wraps);
            const int tried = size < 1.0 ? shares + 1 : shares; /* one without a slip */
            for (int k = 0; k < tried; k++) {
                sawtooth one{wraps, (k + 0.5) / shares};
                one.left = left(one);
                best = one.left < best.left ? one : best;
            }
            trials.push_back(best);
        }
    }
    const auto is_better = [](const sawtooth &a, const sawtooth &b) { return a.left < b.left; };
    std::sort(trials.begin(), trials.end(), is_better);
    trials.resize(std::min(trials.size(), refined));
    for (sawtooth &one : trials) {
        refine(one, 0.25 * std::abs(one.wraps) / std::max(1.0, 2.0 * std::abs(one.wraps)),
               0.25 / shares_of(one.wraps), left);
    }
    std::sort(trials.begin(), trials.end(), is_better);
    std::vector<clock_guess> guesses;
    for (const sawtooth &one : trials) {
        const clock_guess guess = guess_of(one, duration_s, period_s);
        const bool is_known = std::any_of(guesses.begin(), guesses.end(), [&](const clock_guess &other) {
            return std::abs(other.drift_ppm - guess.drift_ppm) < 0.02 * std::abs(guess.drift_ppm) &&
                   std::abs(other.phase_ms - guess.phase_ms) < 20.0 * period_s; /* a fiftieth of the period */
        });
        if (!is_known && guesses.size() < static_cast<std::size_t>(count)) {
            guesses.push_back(guess);
        }
    }
    return guesses;
}

} // namespace berth
