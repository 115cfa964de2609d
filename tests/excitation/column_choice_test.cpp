#include "excitation/search/column_choice.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "support/random.hpp"

namespace veridyn {
namespace {

std::vector<int> in_order(Eigen::Index columns) {
  std::vector<int> out(static_cast<size_t>(columns));
  std::iota(out.begin(), out.end(), 0);
  return out;
}

double volume(const MatrixXd& W, const std::vector<int>& chosen) {
  const MatrixXd A = W.colwise().normalized()(Eigen::all, chosen);
  return std::sqrt(std::max(0.0, (A.transpose() * A).determinant()));
}

// A zero column, a copy in other units and a sum are left out; so is what those that are taken already span.
TEST(ChosenColumns, AreLinearlyIndependent) {
  Random random(3);
  MatrixXd W(40, 6);
  for (int c = 0; c < 6; ++c) W.col(c) = random.vector(40, -1, 1);
  W.col(1).setZero();
  W.col(3) = 1000.0 * W.col(0);
  W.col(5) = W.col(0) - W.col(2);
  std::vector<int> chosen = veridyn::independent_columns(W, in_order(6), {}, 0.0);
  EXPECT_EQ(chosen.size(), 3U);
  for (const int c : chosen) EXPECT_NE(c, 1);
  chosen = veridyn::independent_columns(W, in_order(6), {0, 4}, 0.0);
  ASSERT_EQ(chosen.size(), 1U);
  EXPECT_TRUE(chosen[0] == 2 || chosen[0] == 5);
  EXPECT_TRUE(veridyn::independent_columns(W, {1, 3}, {0}, 0.0).empty());
  // Equal columns count in the order that is given.
  EXPECT_EQ(veridyn::independent_columns(W, {3, 0}, {}, 0.0), std::vector<int>{3});
  EXPECT_EQ(veridyn::independent_columns(W, {0, 3}, {}, 0.0), std::vector<int>{0});
}

// A column that hardly differs from the others is taken where little is enough.
TEST(ChosenColumns, ExcludeColumnsThatAddLessThanTheShare) {
  MatrixXd W = MatrixXd::Identity(3, 2);
  W(0, 1) = 1.0;
  W(1, 1) = 0.05;
  EXPECT_EQ(veridyn::independent_columns(W, {0, 1}, {}, 0.0).size(), 2U);
  EXPECT_EQ(veridyn::independent_columns(W, {0, 1}, {}, 0.1).size(), 1U);
}

TEST(ChosenColumns, AreSwappedForALargerVolume) {
  Random random(5);
  MatrixXd W(30, 8);
  for (int c = 0; c < 8; ++c) W.col(c) = random.vector(30, -1, 1);
  W.col(1) = W.col(0) + 0.01 * W.col(1);  // nearly the same
  std::vector<int> chosen = {0, 1, 2};
  const double before = volume(W, chosen);
  improve_choice(W, chosen);
  EXPECT_GT(volume(W, chosen), 10.0 * before);
  for (int out = 0; out < 3; ++out) {  // no further swap is worth it
    for (int in = 0; in < 8; ++in) {
      std::vector<int> other = chosen;
      other[out] = in;
      EXPECT_LT(volume(W, other), 1.011 * volume(W, chosen));
    }
  }
  std::vector<int> all = in_order(8);
  improve_choice(W, all);
  EXPECT_EQ(all, in_order(8));
}

}  // namespace
}  // namespace veridyn
