#include "coupled_mode.h"

#include <cmath>
#include <cstdio>
#include <Eigen/Core>

#include "../../firmware/pi.h"
#include "../solver/factors.h"

namespace berth
{

namespace
{

constexpr double visible_share = 0.05;
constexpr double near_factor = 2.0;

/* Of the tool's velocity by a force on it, what this mode and its conjugate have: 1 / mass where nothing is damped.
 */
double mobility_of(const linear_arm &both, const Eigen::RowVectorXd &way, std::complex<double> s,
                   const Eigen::VectorXcd &q)
{
    const std::complex<double> at_tool = (way * q)(0);
    const std::complex<double> size = (q.transpose() * (2.0 * s * both.inertia + both.damping) * q)(0);
    return 2.0 * std::abs(s * at_tool * at_tool / size);
}

} // namespace

double coupled_mode::frequency_Hz() const
{
    return s.imag() / two_pi;
}

std::vector<coupled_mode> visible_modes(const arm_config &config, const reduction_choice &choice,
                                        const std::vector<beam_mode> &object)
{
    const linear_arm whole = linearise(config, choice.pose_rad);
    const Eigen::MatrixXd basis = choice.is_guided
                                      ? guided_basis(whole, choice.direction)
                                      : Eigen::MatrixXd(Eigen::MatrixXd::Identity(whole.count(), whole.count()));
    const linear_arm moving = combined(whole, basis);
    const linear_arm both = with_object(moving, choice.direction.normalized().transpose() * moving.tool_way, object);
    const Eigen::RowVectorXd way = choice.direction.normalized().transpose() * both.tool_way;
    const double mobility = (way * positive_solutions(both.inertia, way.transpose()))(0);
    const Eigen::Index further = both.count() - basis.cols();
    std::vector<coupled_mode> modes;
    for (const std::complex<double> &s : eigenvalues_of(both)) {
        if (!(s.imag() > 0.0)) {
            continue;
        }
        const Eigen::VectorXcd q = shape_of(both, s);
        const double share = mobility_of(both, way, s, q) / mobility;
        if (!(share >= visible_share)) {
            continue;
        }
        coupled_mode mode = {s, share, Eigen::VectorXcd(whole.count() + further)};
        mode.shape << basis * q.head(basis.cols()), q.tail(further);
        mode.shape /= (way * q)(0);
        modes.push_back(std::move(mode));
    }
    return modes;
}

const coupled_mode *nearest_mode(const std::vector<coupled_mode> &modes, double frequency_Hz)
{
    const coupled_mode *nearest = nullptr;
    double least = std::log(near_factor);
    for (const coupled_mode &mode : modes) {
        const double distance = std::fabs(std::log(mode.frequency_Hz() / frequency_Hz));
        if (distance <= least) {
            least = distance;
            nearest = &mode;
        }
    }
    return nearest;
}

std::string none_is_near(const std::vector<coupled_mode> &modes, double frequency_Hz)
{
    if (!(frequency_Hz > 0.0)) {
        return "with the object the reduction does not swing";
    }
    char text[160];
    std::snprintf(text, sizeof text,
                  "with the object no swing of the whole arm that the tool shows is within a factor of %g of the "
                  "reduction's, %.4g Hz",
                  near_factor, frequency_Hz);
    std::string words = text;
    for (const coupled_mode &mode : modes) {
        std::snprintf(text, sizeof text, "%s%.4g", &mode == &modes.front() ? "; it shows " : ", ",
                      mode.frequency_Hz());
        words += text;
    }
    return modes.empty() ? words : words + " Hz";
}

} // namespace berth
