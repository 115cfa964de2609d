#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>

namespace veridyn {

/// |a - b| <= tolerance in every entry; a failure names the worst one.
inline testing::AssertionResult near(const Eigen::Ref<const Eigen::MatrixXd>& a,
                                     const Eigen::Ref<const Eigen::MatrixXd>& b, double tolerance) {
  if (a.rows() != b.rows() || a.cols() != b.cols()) {
    return testing::AssertionFailure() << "sizes differ: " << a.rows() << " x " << a.cols()
                                       << " and " << b.rows() << " x " << b.cols();
  }
  for (Eigen::Index j = 0; j < a.cols(); ++j) {
    for (Eigen::Index i = 0; i < a.rows(); ++i) {
      // Written so that a NaN fails as well.
      if (std::abs(a(i, j) - b(i, j)) <= tolerance) continue;
      Eigen::Index row = i;
      Eigen::Index col = j;
      if ((a - b).allFinite()) (a - b).cwiseAbs().maxCoeff(&row, &col);
      return testing::AssertionFailure()
             << "entry (" << row << ", " << col << "): " << a(row, col) << " and " << b(row, col)
             << " differ by " << a(row, col) - b(row, col) << ", allowed is " << tolerance;
    }
  }
  return testing::AssertionSuccess();
}

}  // namespace veridyn
