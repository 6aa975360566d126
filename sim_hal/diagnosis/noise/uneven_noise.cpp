#include "uneven_noise.h"

#include <cmath>
#include <cstddef>

#include <Eigen/Core>

#include "../../solver/factors.h"
#include "../formatted.h"

namespace berth
{

namespace
{

/* Mean squares over moments of the record, one a row: of what the output ought to do, and of the error. */
struct moments_of_block {
    Eigen::MatrixX3d causes; /* 1, square of the velocity, square about the mean */
    Eigen::VectorXd error;
};

moments_of_block moments_of(const std::vector<double> &output, const std::vector<double> &error,
                            const std::vector<row_use> &uses, double period_s)
{
    constexpr double moment_s = 0.5;
    const auto rows = static_cast<std::size_t>(std::max(8.0, std::round(moment_s / period_s)));
    double sum = 0.0;
    for (std::size_t n = 0; n < output.size(); n++) {
        sum += output[n] - error[n];
    }
    const double mean = sum / static_cast<double>(output.size());
    const auto ideal = [&](std::size_t n) { return output[n] - error[n] - mean; };
    std::vector<Eigen::Vector4d> all;
    for (std::size_t begin = 1; begin + rows < output.size(); begin += rows) {
        Eigen::Vector4d squares = Eigen::Vector4d::Zero();
        for (std::size_t n = begin; n < begin + rows && uses[n] != row_use::none; n++) {
            const double velocity = (ideal(n + 1) - ideal(n - 1)) / (2.0 * period_s);
            squares += Eigen::Vector4d(1.0, velocity * velocity, ideal(n) * ideal(n), error[n] * error[n]);
        }
        if (squares[0] == static_cast<double>(rows)) {
            all.emplace_back(squares / squares[0]);
        }
    }
    moments_of_block made{Eigen::MatrixX3d(all.size(), 3), Eigen::VectorXd(all.size())};
    for (std::size_t i = 0; i < all.size(); i++) {
        made.causes.row(static_cast<Eigen::Index>(i)) = all[i].head<3>();
        made.error[static_cast<Eigen::Index>(i)] = all[i][3];
    }
    return made;
}

/* Variance of the error by a unit of the square of velocity and size each, where that is beyond doubt; else 0. What
 * is more than all of the error has another cause take away from it, as velocity and a constant do that never part.
 */
struct growth {
    double with_velocity = 0.0; /* s^2 */
    double with_size = 0.0;
};

growth growth_of(const moments_of_block &moments)
{
    constexpr Eigen::Index moments_min = 20;
    constexpr double sure = 6.0;  /* standard deviations */
    constexpr double much = 0.25; /* of the error's mean square */
    growth found;
    if (moments.error.size() < moments_min) {
        return found;
    }
    const Eigen::Vector3d scale = moments.causes.colwise().mean();
    if (scale.minCoeff() <= 0.0) {
        return found;
    }
    const Eigen::MatrixX3d causes = moments.causes * scale.cwiseInverse().asDiagonal();
    const Eigen::Matrix3d covariance = inverse(causes.transpose() * causes);
    const Eigen::Vector3d shares = covariance * (causes.transpose() * moments.error);
    const auto freedom = static_cast<double>(moments.error.size() - 3);
    const double variance = (moments.error - causes * shares).squaredNorm() / freedom;
    const double mean = moments.error.mean();
    const auto is_clear = [&](Eigen::Index i) {
        return shares[i] <= mean && shares[i] > sure * std::sqrt(variance * covariance(i, i)) &&
               shares[i] > much * mean;
    };
    found.with_velocity = is_clear(1) ? shares[1] / scale[1] : 0.0;
    found.with_size = is_clear(2) ? shares[2] / scale[2] : 0.0;
    return found;
}

const std::vector<double> &output_of(block block, const record &data)
{
    return block == block::manipulator ? data.command_position_m
           : block == block::robot     ? data.robot_position_m
                                       : data.force_N;
}

} // namespace

namespace
{

/* What is left of a motion goes on from row to row, and noise jumps. */
bool is_noise(const block_diagnosis &block)
{
    constexpr double goes_on = 0.5; /* correlation of neighbours */
    constexpr double hardly_more = 1.3;
    double squares = 0.0;
    double neighbours = 0.0;
    for (std::size_t n = 1; n < block.error_after.size(); n++) {
        squares += block.error_after[n] * block.error_after[n];
        neighbours += block.error_after[n] * block.error_after[n - 1];
    }
    return neighbours < goes_on * squares && block.fit_rms.after < hardly_more * block.floor.rms;
}

} // namespace

std::vector<std::string> noise_that_follows_motion(const std::vector<block_diagnosis> &blocks, const record &data)
{
    std::vector<std::string> lines;
    for (const block_diagnosis &block : blocks) {
        if (block.block == block::manipulator || !is_noise(block)) {
            continue; /* a manipulator is replayed in windows, in each of which its error grows */
        }
        const growth found =
            growth_of(moments_of(output_of(block.block, data), block.error_after, block.uses, data.period_s));
        const std::string name(block_names[static_cast<std::size_t>(block.block)]);
        if (found.with_velocity > 0.0) {
            lines.push_back("the noise of the " + name +
                            formatted(" grows with its velocity, as of a delay that jitters by %.3g ms rms",
                                      1e3 * std::sqrt(found.with_velocity)) +
                            "; no effect of the library does that");
        }
        if (found.with_size > 0.0) {
            lines.push_back("the noise of the " + name +
                            formatted(" grows with its size, as of a gain that wanders by %.3g %% rms",
                                      1e2 * std::sqrt(found.with_size)) +
                            "; no effect of the library does that");
        }
    }
    return lines;
}

} // namespace berth
