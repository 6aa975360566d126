#include "motion_features.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace berth
{

namespace
{

using signal = std::vector<double>;

signal derivative(const signal &x, const std::vector<record_segment> &segments, double period_s)
{
    signal rate(x.size(), 0.0);
    for (const record_segment &part : segments) {
        for (std::size_t n = part.begin + 1; n + 1 < part.end; n++) {
            rate[n] = (x[n + 1] - x[n - 1]) / (2.0 * period_s);
        }
    }
    return rate;
}

double largest(const signal &x)
{
    double size = 1e-300;
    for (const double value : x) {
        size = std::max(size, std::abs(value));
    }
    return size;
}

void scale_to_one(signal &x)
{
    const double size = largest(x);
    for (double &value : x) {
        value /= size;
    }
}

/* Direction with memory: what a play or a presliding friction of this length keeps of it. */
signal direction_memory(const signal &x, double length)
{
    signal z(x.size(), 0.0);
    for (std::size_t n = 1; n < x.size(); n++) {
        const double way = (x[n] - x[n - 1]) / length;
        const double direction = way < 0.0 ? -1.0 : 1.0;
        z[n] = direction + (z[n - 1] - direction) * std::exp(-std::abs(way));
    }
    return z;
}

class feature_maker
{
  public:
    explicit feature_maker(const record &record) : record_(record) {}

    template <typename function>
    void add(error_class kind, function value)
    {
        feature made{kind, signal(record_.size())};
        for (std::size_t n = 0; n < record_.size(); n++) {
            made.values[n] = value(n);
        }
        features.push_back(std::move(made));
    }

    /* From `first` on. */
    void add_lags(const signal &x, int first)
    {
        for (const int lag : {-6, -4, -2, -1, 0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32}) {
            if (lag < first) {
                continue;
            }
            add(error_class::linear, [&](std::size_t n) {
                const auto at = static_cast<std::ptrdiff_t>(n) - lag;
                const auto last = static_cast<std::ptrdiff_t>(x.size()) - 1;
                return x[static_cast<std::size_t>(std::min(std::max<std::ptrdiff_t>(at, 0), last))];
            });
        }
    }

    /* Laws of position, velocity and time. */
    void add_laws(signal x, signal v, const std::optional<int> &first_lag)
    {
        scale_to_one(x);
        scale_to_one(v);
        const double span = static_cast<double>(record_.size());
        const auto sign = [](double value) { return value > 0.0 ? 1.0 : value < 0.0 ? -1.0 : 0.0; };
        const auto time = [&](std::size_t n) { return 2.0 * static_cast<double>(n) / span - 1.0; };
        if (first_lag) {
            add_lags(x, *first_lag);
        } else {
            add(error_class::linear, [&](std::size_t n) { return x[n]; });
            add(error_class::linear, [&](std::size_t n) { return v[n]; });
        }
        add(error_class::even, [](std::size_t) { return 1.0; });
        features.back().is_constant = true;
        add(error_class::even, [&](std::size_t n) { return x[n] * x[n]; });
        add(error_class::even, [&](std::size_t n) { return v[n] * v[n]; });
        add(error_class::even, [&](std::size_t n) { return std::abs(v[n]); });
        add(error_class::odd, [&](std::size_t n) { return x[n] * x[n] * x[n]; });
        add(error_class::odd, [&](std::size_t n) { return x[n] * std::abs(x[n]); });
        add(error_class::odd, [&](std::size_t n) { return v[n] * std::abs(v[n]); });
        add(error_class::odd, [&](std::size_t n) { return v[n] * v[n] * v[n]; });
        add(error_class::odd, [&](std::size_t n) { return x[n] * x[n] * v[n]; });
        add(error_class::odd, [&](std::size_t n) { return sign(x[n]); });
        add(error_class::odd, [&](std::size_t n) { return std::max(std::abs(x[n]) - 0.7, 0.0) * sign(x[n]); });
        add(error_class::odd, [&](std::size_t n) { return std::max(std::abs(v[n]) - 0.6, 0.0) * sign(v[n]); });
        add(error_class::hysteresis, [&](std::size_t n) { return sign(v[n]); });
        for (const double length : {0.01, 0.05, 0.25}) {
            const signal memory = direction_memory(x, length);
            add(error_class::hysteresis, [&](std::size_t n) { return memory[n]; });
        }
        add(error_class::drift, [&](std::size_t n) { return time(n); });
        add(error_class::drift, [&](std::size_t n) { return time(n) * time(n); });
        for (const double length : {0.05, 0.15}) { /* warming up; of the record */
            add(error_class::drift,
                [&](std::size_t n) { return std::exp(-static_cast<double>(n) / (length * span)); });
        }
        add(error_class::drift, [&](std::size_t n) { return time(n) * x[n]; });
        add(error_class::drift, [&](std::size_t n) { return time(n) * v[n]; });
    }

    /* Of what is known in some rows, and how it changes between rows that are. */
    void add_shape(signal y, std::vector<bool> is_known)
    {
        for (int order = 0; order < 5; order++) {
            scale_to_one(y);
            features.push_back({error_class::linear, y, false, true});
            change(y, is_known);
        }
    }

    std::vector<feature> features;

  private:
    void change(signal &y, std::vector<bool> &is_known) const
    {
        signal made(y.size(), 0.0);
        std::vector<bool> are_both(y.size(), false);
        for (const record_segment &part : record_.segments) {
            for (std::size_t n = part.begin + 2; n < part.end; n++) {
                are_both[n] = is_known[n] && is_known[n - 1];
                made[n] = are_both[n] ? y[n] - y[n - 1] : 0.0;
            }
        }
        y = std::move(made);
        is_known = std::move(are_both);
    }

    const record &record_;
};

/* The noise of the force moves the manipulator, and that the command: from the tick after it on the command knows of
 * it. Motion that follows such a command explains that noise and says nothing about the hardware. */
int first_lag_before_reaction(const record &record, const rig &rig)
{
    if (record.moves_as_measured()) {
        return 0;
    }
    const double late_s = 1e-3 * rig.robot.dead_time_ms + 1e-9 * static_cast<double>(sync_wait_ns(rig));
    return -static_cast<int>(late_s / record.period_s);
}

} // namespace

std::vector<feature> features_of_motion(const block_model &model, const rig &rig, const std::vector<double> &error)
{
    const record &record = model.data();
    feature_maker maker(record);
    if (model.which() == block::manipulator) {
        const signal &x = record.command_position_m;
        maker.add_laws(x, derivative(x, record.segments, record.period_s), {});
        signal force = record.operator_force_N.empty() ? signal(record.size(), 0.0) : record.operator_force_N;
        for (std::size_t n = 0; n < record.force_N.size(); n++) {
            force[n] -= record.force_N[n];
        }
        if (largest(force) > 1e-290) {
            scale_to_one(force);
            maker.add(error_class::linear, [&](std::size_t n) { return force[n]; });
        }
        for (feature &made : maker.features) {
            model.respond_to_force(rig, made.values);
        }
        return std::move(maker.features);
    }
    /* The motion as the model has it. */
    const signal &x = model.motion().at_tick_m;
    const int reaction = first_lag_before_reaction(record, rig);
    maker.add_laws(x, derivative(x, record.segments, record.period_s), reaction);
    signal simulated(record.size());
    std::vector<bool> is_simulated(record.size()); /* elsewhere it is what was measured, with its noise */
    for (std::size_t n = 0; n < simulated.size(); n++) {
        is_simulated[n] = model.uses()[n] != row_use::none;
        simulated[n] = model.measured()[n] - error[n];
    }
    if (model.which() == block::force) {
        for (feature &made : maker.features) {
            model.respond_to_force(rig, made.values);
        }
        signal f = simulated;
        signal a = derivative(derivative(x, record.segments, record.period_s), record.segments, record.period_s);
        scale_to_one(a);
        maker.add_lags(a, reaction + 2); /* a is known two ticks later */
        scale_to_one(f);
        maker.add(error_class::odd, [&](std::size_t n) { return f[n] * std::abs(f[n]); });
        maker.add(error_class::odd, [&](std::size_t n) { return f[n] * f[n] * f[n]; });
        maker.add(error_class::even, [&](std::size_t n) { return f[n] * f[n]; });
        maker.add(error_class::even, [&](std::size_t n) { return std::abs(f[n]); });
        maker.add(error_class::drift, [&](std::size_t n) {
            return f[n] * (2.0 * static_cast<double>(n) / static_cast<double>(f.size()) - 1.0);
        });
    }
    maker.add_shape(std::move(simulated), std::move(is_simulated));
    return std::move(maker.features);
}

} // namespace berth
