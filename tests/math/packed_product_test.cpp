#include "math/packed_product.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>

#include "math/processor.hpp"
#include "support/near.hpp"
#include "support/random.hpp"
#include "veridyn/math/types.hpp"

// Products of matrices against their definition: every remainder of rows, columns and inner indices
// after panels of twelve, four and two, whole matrices and blocks of larger ones.

namespace veridyn {
namespace {

MatrixXd random_matrix(Random& random, Eigen::Index rows, Eigen::Index cols) {
  MatrixXd out(rows, cols);
  for (double& x : out.reshaped()) x = random.in(-1.0, 1.0);
  return out;
}

MatrixXd by_definition(const MatrixXd& A, const MatrixXd& B) {
  MatrixXd C = MatrixXd::Zero(A.rows(), B.cols());
  for (Eigen::Index i = 0; i < C.rows(); ++i) {
    for (Eigen::Index j = 0; j < C.cols(); ++j) {
      for (Eigen::Index k = 0; k < A.cols(); ++k) C(i, j) += A(i, k) * B(k, j);
    }
  }
  return C;
}

TEST(PackedProduct, EqualsTheDefinition) {
  Random random(71);
  for (const int rows : {1, 2, 3, 7, 12, 13, 18, 23, 40}) {
    for (const int cols : {1, 3, 4, 6, 9, 17}) {
      for (const int depth : {1, 5, 24, 301}) {
        const MatrixXd A = random_matrix(random, rows, depth);
        const MatrixXd B = random_matrix(random, depth, cols);
        const MatrixXd expected = by_definition(A, B);
        const double rounding = 1e-15 * (depth + 1);
        EXPECT_TRUE(near(MatrixXd(A * B), expected, rounding));
        const MatrixXd At = A.transpose();
        EXPECT_TRUE(near(MatrixXd(At.transpose() * B), expected, rounding));
        MatrixXd large = MatrixXd::Constant(rows + 3, cols + 2, 2.0);
        large.block(1, 2, rows, cols).noalias() -= 0.5 * (A * B);
        EXPECT_TRUE(near(large.block(1, 2, rows, cols), (2.0 - 0.5 * expected.array()).matrix(), rounding));
        EXPECT_TRUE((large.row(0).array() == 2.0).all() && (large.bottomRows(2).array() == 2.0).all() &&
                    (large.leftCols(2).array() == 2.0).all());
      }
    }
  }
}

TEST(PackedProduct, SolvesTriangularSystems) {
  Random random(72);
  for (const int n : {5, 31, 70}) {
    MatrixXd R = random_matrix(random, n, n);
    R.diagonal().array() += 2.0 * n;
    const MatrixXd B = random_matrix(random, n, 11);
    const MatrixXd upper = R.triangularView<Eigen::Upper>();
    const MatrixXd x = upper.triangularView<Eigen::Upper>().solve(B);
    EXPECT_TRUE(near(by_definition(upper, x), B, 1e-13));
  }
}

// Machines of either width give the same digits.
TEST(PackedProduct, BothWidthsAreEqualToTheLastBit) {
  if (widest_instruction_set() < InstructionSet::kAvx512 || packed_product_avx512() == nullptr)
    GTEST_SKIP() << "a processor or a build without AVX-512";
  Random random(73);
  for (const int rows : {1, 2, 7, 8, 23, 24, 61}) {
    for (const int cols : {1, 3, 4, 5, 8, 13}) {
      const long depth = 19;
      const long packed = rows + cols;
      const VectorXd A = random.vector(static_cast<int>(rows * depth), -1, 1);
      const VectorXd B = random.vector(static_cast<int>(cols * depth), -1, 1);
      MatrixXd narrow = MatrixXd::Constant(packed, cols, 2.0);
      MatrixXd wide = narrow;
      const auto product = [&](MatrixXd& C) {
        return PackedBlocks{A.data(), B.data(), C.data(), packed, rows, depth, cols, depth, depth, 0, 0, 0.7};
      };
      packed_product_avx2()(product(narrow));
      packed_product_avx512()(product(wide));
      EXPECT_TRUE(narrow == wide) << rows << " x " << cols;
      EXPECT_TRUE((wide.bottomRows(cols).array() == 2.0).all());
    }
  }
}

TEST(PackedProduct, Avx2VersionExistsOnAProcessorWithAvx2) {
#if defined(__x86_64__)
  if (widest_instruction_set() < InstructionSet::kAvx2) GTEST_SKIP() << "a processor without AVX2";
  EXPECT_NE(packed_product_avx2(), nullptr);
#else
  GTEST_SKIP() << "x86 only";
#endif
}

}  // namespace
}  // namespace veridyn
