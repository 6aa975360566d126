#include "response.h"

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

tangent_space::tangent_space(block_model &model, const noise_model &noise, const fit_result &at,
                             const Eigen::VectorXd &white)
{
    basis_ = Eigen::MatrixXd::Zero(white.size(), 0);
    if (at.parameters.empty()) {
        return;
    }
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(white.size(), static_cast<Eigen::Index>(at.parameters.size()));
    for (std::size_t i = 0; i < at.parameters.size(); i++) {
        const free_parameter &parameter = at.parameters[i];
        rig moved = at.rig;
        double &value = *static_cast<double *>(parameter.key->member(moved));
        const double place = (value - parameter.low) / (parameter.high - parameter.low);
        if (place < 0.01 || place > 0.99) {
            continue; /* at a bound it cannot make up for anything more */
        }
        value += 1e-4 * (value != 0.0 ? value : parameter.high);
        jacobian.col(static_cast<Eigen::Index>(i)) = white_error(model, noise, moved) - white;
    }
    for (Eigen::Index i = 0; i < jacobian.cols(); i++) {
        const double size = jacobian.col(i).norm();
        jacobian.col(i) /= size > 0.0 ? size : 1.0;
    }
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(jacobian);
    basis_ = qr.householderQ() * Eigen::MatrixXd::Identity(white.size(), qr.rank());
}

} // namespace berth
