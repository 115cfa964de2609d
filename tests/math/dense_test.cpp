#include "math/dense.hpp"

#include <gtest/gtest.h>

namespace veridyn {
namespace {

// Recordings that determine nothing leave no column behind.
TEST(AnOrthonormalBasis, OfNoColumnsIsEmpty) {
  const MatrixXd basis = orthonormal_basis(MatrixXd(5, 0));
  EXPECT_EQ(basis.rows(), 5);
  EXPECT_EQ(basis.cols(), 0);
}

TEST(AnOrthonormalBasis, SpansDependentColumnsOnce) {
  MatrixXd columns(3, 3);
  // clang-format off
  columns << 1, 2, 0,
             1, 2, 1,
             0, 0, 0;
  // clang-format on
  const MatrixXd basis = orthonormal_basis(columns);
  ASSERT_EQ(basis.cols(), 2);
  EXPECT_LT((basis.transpose() * basis - MatrixXd::Identity(2, 2)).norm(), 1e-14);
  EXPECT_LT((basis * (basis.transpose() * columns) - columns).norm(), 1e-14);
}

}  // namespace
}  // namespace veridyn
