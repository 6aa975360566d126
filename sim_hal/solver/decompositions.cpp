#include "decompositions.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>

namespace berth
{

Eigen::VectorXcd eigenvalues(const Eigen::MatrixXd &matrix)
{
    return matrix.eigenvalues();
}

schur_form real_schur(const Eigen::MatrixXd &a)
{
    const Eigen::RealSchur<Eigen::MatrixXd> schur(a);
    return {schur.matrixT(), schur.matrixU()};
}

eigenpairs generalised_eigenpairs(const Eigen::MatrixXd &a, const Eigen::MatrixXd &b)
{
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(a, b);
    return {solver.eigenvalues(), solver.eigenvectors()};
}

eigenpairs symmetric_eigenpairs(const Eigen::MatrixXd &a)
{
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(a);
    return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::VectorXcd least_singular_vector(const Eigen::MatrixXcd &a)
{
    const Eigen::JacobiSVD<Eigen::MatrixXcd, Eigen::NoQRPreconditioner> parts(a, Eigen::ComputeFullV);
    return parts.matrixV().rightCols(1);
}

Eigen::MatrixXd orthonormal_basis(const Eigen::MatrixXd &columns)
{
    return Eigen::HouseholderQR<Eigen::MatrixXd>(columns).householderQ();
}

Eigen::MatrixXd column_space(const Eigen::MatrixXd &columns)
{
    if (columns.cols() == 0) {
        return columns;
    }
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns);
    if (qr.rank() == 0) { /* a reflection of no columns would step into memory that is not there */
        return Eigen::MatrixXd::Zero(columns.rows(), 0);
    }
    return qr.householderQ() * Eigen::MatrixXd::Identity(columns.rows(), qr.rank());
}

Eigen::MatrixXd least_squares_solution(const Eigen::MatrixXd &a, const Eigen::MatrixXd &b)
{
    return a.colPivHouseholderQr().solve(b);
}

Eigen::VectorXd full_rank_least_squares(const Eigen::MatrixXd &a, const Eigen::VectorXd &b)
{
    return a.householderQr().solve(b);
}

Eigen::VectorXd least_norm_solution(const Eigen::MatrixXd &a, const Eigen::VectorXd &b)
{
    return a.completeOrthogonalDecomposition().solve(b);
}

} // namespace berth
