#include "identification/estimation/least_squares.hpp"

#include <gtest/gtest.h>

#include <Eigen/QR>

#include "support/random.hpp"

namespace veridyn {
namespace {

// Each column is the solution of all rows but those of one block, from the rows themselves.
TEST(LeastSquares, LeaveOneOutColumnsSolveAllRowsButOneBlock) {
  constexpr int kBlocks = 5, kRowsOfBlock = 7, kColumns = 3;
  Random random(4);
  std::vector<SquareRootInformation> blocks;
  MatrixXd A(kBlocks * kRowsOfBlock, kColumns);
  VectorXd b(A.rows());
  for (Eigen::Index r = 0; r < A.rows(); ++r) {
    for (Eigen::Index c = 0; c < kColumns; ++c) A(r, c) = random.in(-1.0, 1.0);
    b[r] = random.in(-1.0, 1.0);
  }
  for (int k = 0; k < kBlocks; ++k) {
    SquareRootInformation block({"a", "b", "c"});
    block.absorb(A.middleRows(k * kRowsOfBlock, kRowsOfBlock), b.segment(k * kRowsOfBlock, kRowsOfBlock));
    blocks.push_back(block);
  }
  const MatrixXd found = solutions_without(blocks);
  ASSERT_EQ(found.rows(), kColumns);
  ASSERT_EQ(found.cols(), kBlocks);
  for (int k = 0; k < kBlocks; ++k) {
    MatrixXd rest = A;
    VectorXd right = b;
    rest.middleRows(k * kRowsOfBlock, kRowsOfBlock).setZero();
    right.segment(k * kRowsOfBlock, kRowsOfBlock).setZero();
    const VectorXd expected = Eigen::HouseholderQR<MatrixXd>(rest).solve(right);
    EXPECT_LT((found.col(k) - expected).norm(), 1e-12) << k;
  }
  EXPECT_EQ(solutions_without({}).size(), 0);
}

}  // namespace
}  // namespace veridyn
