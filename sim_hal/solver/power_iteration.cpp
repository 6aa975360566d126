#include "power_iteration.h"

#include <cmath>
#include <Eigen/SparseCore>

namespace berth
{

namespace
{

constexpr int products_before = 8000; /* 0.998 to this power is 1e-7 */
constexpr int products_measured = 8000;

/* No eigenvector lacks in it by symmetry, and it is the same each time. */
Eigen::VectorXd uneven_vector(Eigen::Index size)
{
    constexpr double golden_angle_rad = 2.4;
    Eigen::VectorXd v(size);
    for (Eigen::Index i = 0; i < size; i++) {
        v(i) = 1.0 + std::sin(1.0 + golden_angle_rad * static_cast<double>(i));
    }
    return v.normalized();
}

/* Of a line by least squares through values one apart. */
class slope
{
  public:
    explicit slope(int count) : middle_(0.5 * (count - 1)) {}
    void add(int i, double value)
    {
        products_ += (i - middle_) * value;
        squares_ += (i - middle_) * (i - middle_);
    }
    double value() const { return products_ / squares_; }

  private:
    double middle_;
    double products_ = 0.0;
    double squares_ = 0.0;
};

} // namespace

double power_radius(const Eigen::MatrixXd &full)
{
    const Eigen::SparseMatrix<double, Eigen::RowMajor> matrix = full.sparseView(); /* a delay is zeros but for one */
    Eigen::VectorXd v = uneven_vector(matrix.rows());
    Eigen::VectorXd next(matrix.rows());
    double log_length = 0.0;
    slope growth(products_measured);
    for (int i = -products_before; i < products_measured; i++) {
        if (i >= 0) {
            growth.add(i, log_length);
        }
        next = matrix * v;
        const double length = next.norm();
        if (!(length > 0.0)) {
            return 0.0; /* nothing comes back */
        }
        v = next / length;
        log_length += std::log(length);
    }
    return std::exp(growth.value());
}

} // namespace berth
