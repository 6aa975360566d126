#include "response.h"

#include <cmath>
#include <Eigen/Dense>

namespace berth
{

Eigen::VectorXd white_error(block_model &model, const noise_model &noise, const rig &rig)
{
    std::vector<double> error;
    std::vector<double> white;
    model.error(rig, error);
    whiten(noise, error, model.uses(), row_use::fit, white);
    return Eigen::Map<const Eigen::VectorXd>(white.data(), static_cast<Eigen::Index>(white.size()));
}

rig with_values(const rig &base, const effect &effect, const effect_values &values)
{
    rig made = base;
    if (effect.switch_on != nullptr) {
        effect.switch_on(made);
    }
    for (std::size_t i = 0; i < values.size(); i++) {
        set_number(made, effect.parameters[i].key, values[i]);
    }
    return made;
}

known_slopes slopes_at(block_model &model, const noise_model &noise, const fit_result &at,
                       const Eigen::VectorXd &white)
{
    known_slopes made;
    made.white = Eigen::MatrixXd::Zero(white.size(), static_cast<Eigen::Index>(at.parameters.size()));
    for (const free_parameter &parameter : at.parameters) {
        rig moved = at.rig;
        double &value = *static_cast<double *>(parameter.key->member(moved));
        const double inward = value > 0.5 * (parameter.low + parameter.high) ? -1.0 : 1.0;
        const double step = inward * 1e-4 * (value != 0.0 ? std::abs(value) : parameter.high - parameter.low);
        value += step;
        made.white.col(static_cast<Eigen::Index>(made.keys.size())) =
            (white_error(model, noise, moved) - white) / step;
        made.keys.push_back(parameter.key);
    }
    return made;
}

tangent_space::tangent_space(const fit_result &at, const known_slopes &slopes)
{
    basis_ = Eigen::MatrixXd::Zero(slopes.white.rows(), 0);
    if (at.parameters.empty()) {
        return;
    }
    Eigen::MatrixXd jacobian = slopes.white;
    for (Eigen::Index i = 0; i < jacobian.cols(); i++) {
        const free_parameter &parameter = at.parameters[static_cast<std::size_t>(i)];
        const double value = value_of(at.rig, parameter.key->path);
        const double place = (value - parameter.low) / (parameter.high - parameter.low);
        const double size = jacobian.col(i).norm();
        jacobian.col(i) *= place < 0.01 || place > 0.99 || !(size > 0.0) ? 0.0 : 1.0 / size;
    }
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(jacobian);
    basis_ = qr.householderQ() * Eigen::MatrixXd::Identity(jacobian.rows(), qr.rank());
}

} // namespace berth
