#include "math/singular_values.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "math/decompositions.hpp"
#include "support/random.hpp"

namespace veridyn {
namespace {

MatrixXd random_matrix(Random& random, int n) {
  MatrixXd A(n, n);
  for (Eigen::Index j = 0; j < n; ++j) A.col(j) = random.vector(n, -1.0, 1.0);
  return A;
}

void expect_as_jacobi(const MatrixXd& A) {
  const VectorXd found = singular_values(A);
  const VectorXd wanted = Eigen::JacobiSVD<MatrixXd>(A).singularValues();
  ASSERT_EQ(found.size(), wanted.size());
  EXPECT_LT((found - wanted).cwiseAbs().maxCoeff(), 1e-13 * wanted[0] * static_cast<double>(A.cols()));
}

TEST(SingularValues, EqualThoseOfAJacobiDecomposition) {
  Random random(7);
  for (const int n : {1, 2, 3, 26, 98}) {
    const MatrixXd A = random_matrix(random, n);
    expect_as_jacobi(A);
    expect_as_jacobi(1e150 * A);
    expect_as_jacobi(1e-150 * A);
    expect_as_jacobi(MatrixXd(A.triangularView<Eigen::Upper>()));
  }
}

// Twelve decades, and columns that depend on others.
TEST(SingularValues, OfGradedAndSingularMatricesAreAccurate) {
  Random random(8);
  MatrixXd A = random_matrix(random, 30);
  for (int j = 0; j < 30; ++j) A.col(j) *= std::pow(10.0, -0.4 * j);
  expect_as_jacobi(A);
  A.col(7) = A.col(3);
  A.col(9).setZero();
  expect_as_jacobi(A);
  EXPECT_LT(singular_values(A)[29], 1e-15);
}

TEST(SingularValues, OfAnEmptyMatrixAreAnEmptyVector) {
  EXPECT_EQ(singular_values(MatrixXd(0, 0)).size(), 0);
  EXPECT_EQ(singular_values(MatrixXd::Zero(4, 4)), VectorXd::Zero(4));
  EXPECT_DOUBLE_EQ(singular_values(MatrixXd::Constant(1, 1, -3.0))[0], 3.0);
  EXPECT_TRUE(std::isnan(singular_values(MatrixXd::Constant(2, 2, NAN))[1]));
}

}  // namespace
}  // namespace veridyn
