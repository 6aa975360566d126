#include "manipulator_regression.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Core>
#include <iterator>
#include <optional>

#include "../../solver/decompositions.h"

namespace berth
{

namespace
{

/* One stretch, integrated: x and its deflection from the operator's goal against the test function. */
struct stretch {
    double acceleration_m_per_s2; /* over x'' */
    double velocity_m_per_s;      /* of the deflection */
    double deflection_m;
    double square_m2;
    double cube_m3;
    double speed_m_per_s; /* over |x'| */
    double direction;
    double push_N;
};

/* What stands on the side of the inertia in M x'' + ... = push. */
struct term {
    std::string_view key;
    double (*of)(const stretch &);
};

constexpr term terms[] = {
    {"manipulator.mass_kg", [](const stretch &s) { return s.acceleration_m_per_s2; }},
    {"manipulator.damping_N_s_per_m", [](const stretch &s) { return s.velocity_m_per_s; }},
    {"manipulator.stiffness_N_per_m", [](const stretch &s) { return s.deflection_m; }},
    {"manipulator.quadratic_stiffness_N_per_m2", [](const stretch &s) { return s.square_m2; }},
    {"manipulator.cubic_stiffness_N_per_m3", [](const stretch &s) { return s.cube_m3; }},
    {"manipulator.damping_asymmetry_N_s_per_m", [](const stretch &s) { return s.speed_m_per_s; }},
    {"manipulator.coulomb_friction_N", [](const stretch &s) { return s.direction; }},
    {"manipulator.gravity_offset_N", [](const stretch &) { return 1.0; }},
};

/* (1 - s^2)^6 with s from -1 to 1, of weight 1, and its derivatives by time. */
class test_function
{
  public:
    test_function(std::size_t rows, double period_s) : value(rows + 1), slope(rows + 1), bend(rows + 1), middle(rows)
    {
        constexpr double p = 6.0;
        const double half_s = 0.5 * static_cast<double>(rows) * period_s;
        double sum = 0.0;
        const auto place = [&](double row) { return 2.0 * row / static_cast<double>(rows) - 1.0; };
        for (std::size_t i = 0; i <= rows; i++) {
            const double s = place(static_cast<double>(i));
            const double rest = 1.0 - s * s;
            value[i] = std::pow(rest, p);
            slope[i] = -2.0 * p * s * std::pow(rest, p - 1.0) / half_s;
            bend[i] = (4.0 * p * (p - 1.0) * s * s * std::pow(rest, p - 2.0) - 2.0 * p * std::pow(rest, p - 1.0)) /
                      (half_s * half_s);
            sum += value[i];
        }
        for (std::size_t i = 0; i < rows; i++) { /* what is held over a tick counts in its middle */
            middle[i] = std::pow(1.0 - std::pow(place(static_cast<double>(i) + 0.5), 2), p) / sum;
        }
        for (std::size_t i = 0; i <= rows; i++) {
            value[i] /= sum;
            slope[i] /= sum;
            bend[i] /= sum;
        }
    }
    std::vector<double> value;
    std::vector<double> slope;
    std::vector<double> bend;
    std::vector<double> middle;
};

double at(const std::vector<double> &signal, std::size_t row)
{
    return signal.empty() ? 0.0 : signal[row];
}

/* Over two rows to either side, as far as they are of one segment. */
std::vector<double> velocities(const record &data)
{
    constexpr std::size_t aside = 2;
    std::vector<double> made(data.size(), 0.0);
    for (const record_segment &segment : data.segments) {
        for (std::size_t n = segment.begin + aside; n + aside < segment.end; n++) {
            made[n] = (data.command_position_m[n + aside] - data.command_position_m[n - aside]) /
                      (2.0 * static_cast<double>(aside) * data.period_s);
        }
    }
    return made;
}

stretch integrated(const record &data, const test_function &test, std::size_t begin, double direction)
{
    stretch made{};
    made.direction = direction;
    double velocity = 0.0;
    for (std::size_t i = 0; i < test.value.size(); i++) {
        const std::size_t n = begin + i;
        const double x_m = data.command_position_m[n];
        const double off_m = x_m - at(data.operator_position_m, n);
        made.acceleration_m_per_s2 += test.bend[i] * x_m;
        velocity -= test.slope[i] * x_m;
        made.deflection_m += test.value[i] * off_m;
        made.square_m2 += test.value[i] * off_m * off_m;
        made.cube_m3 += test.value[i] * off_m * off_m * off_m;
    }
    double goal_m_per_s = 0.0;
    const std::vector<double> &weight = data.push_within_rows_N.empty() ? test.middle : test.value;
    for (std::size_t i = 0; i < test.middle.size(); i++) {
        made.push_N += weight[i] * (at(data.operator_force_N, begin + i) - at(data.force_N, begin + i));
        goal_m_per_s += test.middle[i] * at(data.operator_velocity_m_per_s, begin + i);
    }
    made.velocity_m_per_s = velocity - goal_m_per_s;
    made.speed_m_per_s = direction * velocity;
    return made;
}

std::vector<stretch> stretches_of(const block_model &model, std::size_t rows)
{
    constexpr double slow = 0.01;   /* of the fastest motion: its direction is known above */
    constexpr double certain = 4.0; /* standard deviations */
    constexpr std::size_t overlap = 4;
    const record &data = model.data();
    const std::vector<double> velocity_m_per_s = velocities(data);
    const test_function test(rows, data.period_s);
    const double noise_rms_m = noise_of_differences(data.command_position_m, model.uses()).rms;
    double fastest = 0.0;
    for (const double v : velocity_m_per_s) {
        fastest = std::max(fastest, std::abs(v));
    }
    const double least_m_per_s = std::max(slow * fastest, certain * noise_rms_m * std::sqrt(0.125) / data.period_s);
    const auto is_of_use = [&](std::size_t n, double direction) {
        return model.uses()[n] == row_use::fit && direction * velocity_m_per_s[n] > least_m_per_s;
    };
    std::vector<stretch> made;
    for (std::size_t begin = 0; begin + rows < data.size(); begin += std::max<std::size_t>(1, rows / overlap)) {
        const double direction = velocity_m_per_s[begin] < 0.0 ? -1.0 : 1.0;
        std::size_t i = 0;
        while (i <= rows && is_of_use(begin + i, direction)) {
            i++;
        }
        if (i > rows) {
            made.push_back(integrated(data, test, begin, direction));
        }
    }
    return made;
}

/* The parameters' values; from the stretches, weighed by what these leave, and what is expected. */
Eigen::VectorXd solution(const Eigen::MatrixXd &stretches, const Eigen::VectorXd &push_N,
                         const std::vector<free_parameter> &parameters)
{
    constexpr int rounds = 3;
    constexpr double overlap = 2.0; /* neighbours share three quarters of their rows: square root of 4 */
    const Eigen::Index count = stretches.rows();
    const auto unknown = static_cast<Eigen::Index>(parameters.size());
    double sigma_N = 1e-3 * std::sqrt(push_N.squaredNorm() / static_cast<double>(count));
    Eigen::VectorXd found = Eigen::VectorXd::Zero(unknown);
    for (int round = 0; round < rounds && sigma_N > 0.0; round++) {
        Eigen::MatrixXd a = Eigen::MatrixXd::Zero(count + unknown, unknown);
        Eigen::VectorXd b = Eigen::VectorXd::Zero(count + unknown);
        a.topRows(count) = stretches / sigma_N;
        b.head(count) = push_N / sigma_N;
        for (Eigen::Index i = 0; i < unknown; i++) {
            const free_parameter &one = parameters[static_cast<std::size_t>(i)];
            if (one.expected_sd < unlimited) {
                a(count + i, i) = 1.0 / one.expected_sd;
                b(count + i) = one.expected / one.expected_sd;
            }
        }
        const Eigen::VectorXd scale = a.colwise().norm().cwiseMax(1e-300);
        const Eigen::VectorXd scaled = least_squares_solution(a * scale.cwiseInverse().asDiagonal(), b);
        found = scaled.cwiseQuotient(scale);
        sigma_N = overlap * std::sqrt((push_N - stretches * found).squaredNorm() / static_cast<double>(count));
    }
    return found;
}

/* `start` with the values of `parameters` as the equation has them, from stretches of this width. */
std::optional<rig> regressed(const block_model &model, const rig &start,
                             const std::vector<free_parameter> &parameters, double width_s)
{
    constexpr std::size_t rows_min = 12;
    constexpr std::size_t stretches_a_parameter = 4;
    const auto rows = static_cast<std::size_t>(width_s / model.data().period_s);
    const std::vector<stretch> stretches = rows < rows_min ? std::vector<stretch>{} : stretches_of(model, rows);
    if (stretches.empty() || stretches.size() < stretches_a_parameter * parameters.size()) {
        return {};
    }
    const auto count = static_cast<Eigen::Index>(stretches.size());
    Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(count, static_cast<Eigen::Index>(parameters.size()));
    Eigen::VectorXd push_N(count);
    for (Eigen::Index n = 0; n < count; n++) {
        push_N(n) = stretches[static_cast<std::size_t>(n)].push_N;
    }
    for (const term &one : terms) {
        const auto free = std::find_if(parameters.begin(), parameters.end(),
                                       [&](const free_parameter &any) { return any.key->path == one.key; });
        for (Eigen::Index n = 0; n < count; n++) {
            const double integral = one.of(stretches[static_cast<std::size_t>(n)]);
            if (free == parameters.end()) {
                push_N(n) -= value_of(start, one.key) * integral;
            } else {
                columns(n, free - parameters.begin()) = integral;
            }
        }
    }
    const Eigen::VectorXd values = solution(columns, push_N, parameters);
    rig made = start;
    for (std::size_t i = 0; i < parameters.size(); i++) {
        const free_parameter &one = parameters[i];
        const double value = values(static_cast<Eigen::Index>(i));
        const bool is_of_base = one.expected_sd < unlimited;
        if (!is_of_base && !(value > one.low && value < one.high)) {
            return {};
        }
        set_number(made, one.key->path, std::clamp(value, one.low, one.high));
    }
    return made;
}

bool belongs_to(const free_parameter &parameter, const effect &effect)
{
    return std::any_of(effect.parameters.begin(), effect.parameters.end(),
                       [&](const effect_parameter &own) { return own.key == parameter.key->path; });
}

/* What the incumbent fits of the base alone. */
std::vector<free_parameter> of_base(const fit_result &incumbent, const std::vector<const effect *> &all)
{
    std::vector<free_parameter> kept;
    std::copy_if(incumbent.parameters.begin(), incumbent.parameters.end(), std::back_inserter(kept),
                 [&](const free_parameter &one) {
                     return std::none_of(all.begin(), all.end(),
                                         [&](const effect *any) { return belongs_to(one, *any); });
                 });
    return kept;
}

std::vector<const effect *> with(std::vector<const effect *> found, const effect &effect)
{
    found.push_back(&effect);
    return found;
}

constexpr std::string_view presliding = "manipulator.coulomb_presliding_m";

} // namespace

std::vector<rig> regressed_starts(const block_model &model, const fit_result &incumbent,
                                  const std::vector<const effect *> &found, const effect &effect)
{
    if (model.which() != block::manipulator || model.rows_per_fact() > 1.0) {
        return {};
    }
    const std::vector<const berth::effect *> all = with(found, effect);
    std::vector<free_parameter> parameters = of_base(incumbent, all);
    for (const berth::effect *const one : all) {
        for (const effect_parameter &own : one->parameters) {
            const bool stands =
                std::any_of(std::begin(terms), std::end(terms), [&](const term &any) { return any.key == own.key; });
            if (stands) {
                parameters = joined(parameters, {{find_key(own.key), own.low, own.high}});
            } else if (own.key != presliding) { /* its way is short beside a stretch */
                return {};
            }
        }
    }
    constexpr double bent_ways[] = {0.0, 1e-5, 1e-4, 1e-3}; /* of the range */
    const std::vector<double> &x = model.data().command_position_m;
    const auto [least, most] = std::minmax_element(x.begin(), x.end());
    std::vector<double> ways = {value_of(incumbent.rig, presliding)};
    if (value_of(incumbent.rig, "manipulator.coulomb_friction_N") > 0.0 || effect.parameters.size() > 1) {
        for (const double share : bent_ways) {
            ways.push_back(share * (*most - *least));
        }
    }
    std::vector<rig> starts;
    for (const double width_s : {0.1, 0.3}) {
        const auto made = regressed(model, incumbent.rig, parameters, width_s);
        for (std::size_t i = 0; made && i < ways.size(); i++) {
            starts.push_back(*made);
            set_number(starts.back(), presliding, ways[i]);
        }
    }
    return starts;
}

std::vector<free_parameter> parameters_about(const rig &start, const fit_result &incumbent,
                                             const std::vector<const effect *> &found, const effect &effect)
{
    const std::vector<const berth::effect *> all = with(found, effect);
    std::vector<free_parameter> parameters = of_base(incumbent, all);
    for (const berth::effect *const one : all) {
        parameters = joined(parameters, effect_parameters(*one, start));
    }
    return parameters;
}

} // namespace berth
