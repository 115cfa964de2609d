#include "identification/estimation/smooth_basis.hpp"

#include <gtest/gtest.h>

namespace veridyn {
namespace {

TEST(SmoothBasis, IsAPartitionOfUnityAndConstantOutsideOfItsRange) {
  const SmoothBasis basis(BasisKind::kSmooth, -0.5, 2.0, 8, 0.01);
  VectorXd inside(basis.size());
  VectorXd end(basis.size());
  VectorXd beyond(basis.size());
  for (double x = -0.5; x <= 2.0; x += 0.1) {
    basis.values(x, inside.data());
    EXPECT_NEAR(inside.sum(), 1.0, 1e-12);
  }
  basis.values(2.0, end.data());
  basis.values(7.0, beyond.data());
  EXPECT_EQ((end - beyond).norm(), 0.0);
}

}  // namespace
}  // namespace veridyn
