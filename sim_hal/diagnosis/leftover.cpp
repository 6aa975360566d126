#include "leftover.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Dense>

namespace berth
{

namespace
{

struct feature {
    error_class kind;
    std::vector<double> values;
};

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

    void add_lags(const signal &x)
    {
        for (const int lag : {-6, -4, -2, -1, 0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32}) {
            add(error_class::linear, [&](std::size_t n) {
                const auto at = static_cast<std::ptrdiff_t>(n) - lag;
                const auto last = static_cast<std::ptrdiff_t>(x.size()) - 1;
                return x[static_cast<std::size_t>(std::min(std::max<std::ptrdiff_t>(at, 0), last))];
            });
        }
    }

    /* Laws of position, velocity and time. */
    void add_laws(signal x, signal v, bool lags)
    {
        scale_to_one(x);
        scale_to_one(v);
        const double span = static_cast<double>(record_.size());
        const auto sign = [](double value) { return value > 0.0 ? 1.0 : value < 0.0 ? -1.0 : 0.0; };
        const auto time = [&](std::size_t n) { return 2.0 * static_cast<double>(n) / span - 1.0; };
        if (lags) {
            add_lags(x);
        } else {
            add(error_class::linear, [&](std::size_t n) { return x[n]; });
            add(error_class::linear, [&](std::size_t n) { return v[n]; });
        }
        add(error_class::even, [](std::size_t) { return 1.0; });
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
        add(error_class::drift, [&](std::size_t n) { return time(n) * x[n]; });
        add(error_class::drift, [&](std::size_t n) { return time(n) * v[n]; });
    }

    std::vector<feature> features;

  private:
    const record &record_;
};

std::vector<feature> make_features(block_model &model, const rig &rig)
{
    const record &record = model.data();
    feature_maker maker(record);
    if (model.which() == block::manipulator) {
        const signal &x = record.command_position_m;
        maker.add_laws(x, derivative(x, record.segments, record.period_s), false);
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
    maker.add_laws(x, derivative(x, record.segments, record.period_s), true);
    if (model.which() == block::force) {
        for (feature &made : maker.features) {
            model.respond_to_force(rig, made.values);
        }
        signal f(record.size());
        std::vector<double> error;
        model.error(rig, error);
        for (std::size_t n = 0; n < f.size(); n++) {
            f[n] = model.measured()[n] - error[n];
        }
        signal a = derivative(derivative(x, record.segments, record.period_s), record.segments, record.period_s);
        scale_to_one(a);
        maker.add_lags(a);
        scale_to_one(f);
        maker.add(error_class::odd, [&](std::size_t n) { return f[n] * std::abs(f[n]); });
        maker.add(error_class::odd, [&](std::size_t n) { return f[n] * f[n] * f[n]; });
        maker.add(error_class::even, [&](std::size_t n) { return f[n] * f[n]; });
        maker.add(error_class::even, [&](std::size_t n) { return std::abs(f[n]); });
        maker.add(error_class::drift, [&](std::size_t n) {
            return f[n] * (2.0 * static_cast<double>(n) / static_cast<double>(f.size()) - 1.0);
        });
    }
    return std::move(maker.features);
}

/* Rows in use, alternately of two halves in blocks. */
constexpr std::size_t blocks = 12;

struct normal_equations {
    Eigen::MatrixXd g;
    Eigen::VectorXd b;
    double square = 0.0;
    double rows = 0.0;
};

Eigen::VectorXd solve(const normal_equations &sums)
{
    Eigen::MatrixXd g = sums.g;
    const Eigen::VectorXd diagonal = g.diagonal();
    for (Eigen::Index i = 0; i < g.rows(); i++) {
        g(i, i) += 1e-7 * diagonal(i) + 1e-6; /* features may depend on each other, or be small against the noise */
    }
    return g.ldlt().solve(sums.b);
}

} // namespace

leftover find_leftover(block_model &model, const noise_model &noise, const rig &rig,
                       const std::vector<double> &error)
{
    const std::vector<feature> features = make_features(model, rig);
    const auto count = static_cast<Eigen::Index>(features.size());
    const std::vector<row_use> &uses = model.uses();
    const std::size_t size = error.size();

    /* Everything white, row by row, so that it can be summed up for either half. */
    const std::size_t order = noise.ar.size();
    const auto white = [&](const signal &x, std::size_t n) {
        double value = x[n];
        for (std::size_t i = 0; i < order; i++) {
            value -= noise.ar[i] * x[n - 1 - i];
        }
        return value / noise.sigma;
    };
    normal_equations halves[2];
    for (normal_equations &half : halves) {
        half.g = Eigen::MatrixXd::Zero(count, count);
        half.b = Eigen::VectorXd::Zero(count);
    }
    constexpr Eigen::Index batch = 256;
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(batch, count);
    Eigen::VectorXd targets = Eigen::VectorXd::Zero(batch);
    Eigen::Index filled = 0;
    int half_of_batch = 0;
    const auto flush = [&] {
        normal_equations &half = halves[half_of_batch];
        const Eigen::MatrixXd block = rows.topRows(filled);
        half.g += block.transpose() * block;
        half.b += block.transpose() * targets.head(filled);
        half.square += targets.head(filled).squaredNorm();
        half.rows += static_cast<double>(filled);
        filled = 0;
    };
    std::size_t run = 0;
    for (std::size_t n = 0; n < size; n++) {
        run = uses[n] == row_use::none ? 0 : run + 1;
        const int half = static_cast<int>(n * blocks / size % 2);
        if (filled == batch || (filled > 0 && half != half_of_batch)) {
            flush();
        }
        half_of_batch = half;
        if (run <= order) {
            continue;
        }
        for (Eigen::Index i = 0; i < count; i++) {
            rows(filled, i) = white(features[static_cast<std::size_t>(i)].values, n);
        }
        targets(filled++) = white(error, n);
    }
    flush();

    leftover result;
    for (int i = 0; i < 2; i++) {
        const Eigen::VectorXd c = solve(halves[i]);
        const normal_equations &unseen = halves[1 - i];
        result.explained += 2.0 * c.dot(unseen.b) - c.dot(unseen.g * c);
    }
    result.rows = (halves[0].rows + halves[1].rows) / noise.rows_per_fact;
    result.share_of_rms = result.explained / std::max(1e-300, halves[0].square + halves[1].square);

    normal_equations all{halves[0].g + halves[1].g, halves[0].b + halves[1].b, 0.0, 0.0};
    const Eigen::VectorXd c = solve(all);
    double strongest = -1.0;
    for (int kind = 0; kind < static_cast<int>(error_class::count); kind++) {
        Eigen::VectorXd part = Eigen::VectorXd::Zero(count);
        for (Eigen::Index i = 0; i < count; i++) {
            if (features[static_cast<std::size_t>(i)].kind == static_cast<error_class>(kind)) {
                part(i) = c(i);
            }
        }
        const double size_of_part = part.dot(all.g * part);
        if (size_of_part > strongest) {
            strongest = size_of_part;
            result.strongest = static_cast<error_class>(kind);
        }
    }
    result.unexplained = error;
    for (std::size_t n = 0; n < size; n++) {
        if (uses[n] != row_use::none) {
            for (Eigen::Index i = 0; i < count; i++) {
                result.unexplained[n] -= c(i) * features[static_cast<std::size_t>(i)].values[n];
            }
        }
    }
    return result;
}

} // namespace berth
