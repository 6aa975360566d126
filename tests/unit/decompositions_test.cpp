#include <doctest/doctest.h>
#include <Eigen/Core>

#include "../../sim_hal/solver/decompositions.h"

TEST_CASE("decompositions: the space of columns that hang together has as many as are independent")
{
    Eigen::MatrixXd columns(4, 3);
    columns << 1, 2, 3, 0, 0, 0, 2, 4, 6, 0, 1, 1; /* the third one: the sum of the others */
    const Eigen::MatrixXd space = berth::column_space(columns);
    REQUIRE(space.cols() == 2);
    CHECK((space.transpose() * space - Eigen::MatrixXd::Identity(2, 2)).norm() < 1e-14);
    CHECK((columns - space * (space.transpose() * columns)).norm() < 1e-14);
}

TEST_CASE("decompositions: columns of zeros span nothing")
{
    for (const Eigen::Index count : {0, 1, 8}) {
        const Eigen::MatrixXd space = berth::column_space(Eigen::MatrixXd::Zero(20, count));
        CHECK(space.rows() == 20);
        CHECK(space.cols() == 0);
    }
}
