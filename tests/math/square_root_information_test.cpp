#include "veridyn/math/square_root_information.hpp"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "math/processor.hpp"
#include "math/triangle_update.hpp"
#include "support/near.hpp"
#include "support/random.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

using Names = std::vector<std::string>;

struct Rows {
  MatrixXd A;
  VectorXd b;
};

Rows random_rows(int rows, int columns, Random& random) {
  Rows out{MatrixXd(rows, columns), random.vector(rows, -2, 2)};
  for (int j = 0; j < columns; ++j) out.A.col(j) = random.vector(rows, -1, 1);
  return out;
}

Names names(int count, const std::string& letter = "x") {
  Names out;
  for (int j = 0; j < count; ++j) out.push_back(letter + std::to_string(j));
  return out;
}

SquareRootInformation factor_of(const Rows& rows, const Names& columns) {
  SquareRootInformation f(columns);
  f.absorb(rows.A, rows.b);
  return f;
}

VectorXd solution(const SquareRootInformation& f) {
  return Eigen::HouseholderQR<MatrixXd>(f.R()).solve(f.z());
}

// Two factors say the same if they give the same sum of squares everywhere: R'R, R'z and z'z +
// rho^2 are equal. (R itself is unique only up to the signs of its rows.)
testing::AssertionResult same(const SquareRootInformation& a, const SquareRootInformation& b) {
  if (a.columns() != b.columns()) return testing::AssertionFailure() << "columns differ";
  const double scale = 1.0 + a.R().squaredNorm() + a.rhs_norm2();
  auto squares = near(a.R().transpose() * a.R(), b.R().transpose() * b.R(), 1e-12 * scale);
  if (!squares) return squares << " in R'R";
  auto mixed = near(a.R().transpose() * a.z(), b.R().transpose() * b.z(), 1e-12 * scale);
  if (!mixed) return mixed << " in R'z";
  if (!(std::abs(a.rhs_norm2() - b.rhs_norm2()) <= 1e-12 * scale)) {
    return testing::AssertionFailure()
           << "||b||^2 is " << a.rhs_norm2() << " and " << b.rhs_norm2();
  }
  if (a.rows() != b.rows())
    return testing::AssertionFailure() << a.rows() << " and " << b.rows() << " rows";
  return testing::AssertionSuccess();
}

class OfAnyShape : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Rows, OfAnyShape, testing::Values(0, 1, 3, 6, 7, 8, 255, 256, 257, 3000),
                         [](const auto& test) { return std::to_string(test.param); });

// A factor of many columns keeps few rows as they are.
constexpr int kMany = 136;

TEST_P(OfAnyShape, ResidualSumOfSquaresEqualsThatOfTheRows) {
  Random random(1);
  for (const int columns : {7, kMany}) {
    const Rows rows = random_rows(GetParam(), columns, random);
    const SquareRootInformation f = factor_of(rows, names(columns));
    EXPECT_EQ(f.rows(), GetParam());
    EXPECT_TRUE(f.R().isUpperTriangular(0.0));
    EXPECT_NEAR(f.rhs_norm2(), rows.b.squaredNorm(), 1e-12 * (1.0 + rows.b.squaredNorm()));
    EXPECT_TRUE(near(f.column_norms(), rows.A.colwise().norm().transpose(), 1e-11));
    const MatrixXd T = random_rows(columns, 3, random).A;
    EXPECT_TRUE(same(f.transformed(T, names(3, "y")), factor_of({rows.A * T, rows.b}, names(3, "y"))));
    EXPECT_TRUE(same(f, SquareRootInformation(names(columns), f.R(), f.z(), f.rho2(), f.rows())));
    for (int k = 0; k < 10; ++k) {
      const VectorXd x = random.vector(columns, -5, 5);
      const double direct = (rows.A * x - rows.b).squaredNorm();
      EXPECT_NEAR(f.residual2(x), direct, 1e-12 * (1.0 + direct));
    }
  }
}

TEST_P(OfAnyShape, BlocksGiveTheFactorOfAllRows) {
  Random random(2);
  const Rows rows = random_rows(GetParam(), 5, random);
  const SquareRootInformation once = factor_of(rows, names(5));
  for (const Eigen::Index block : {1, 2, 64, 999}) {
    SquareRootInformation f(names(5));
    for (Eigen::Index at = 0; at < rows.A.rows(); at += block) {
      const Eigen::Index n = std::min<Eigen::Index>(block, rows.A.rows() - at);
      f.absorb(rows.A.middleRows(at, n), rows.b.segment(at, n));
    }
    EXPECT_TRUE(same(f, once)) << "blocks of " << block;
  }
}

// No vector x can go below rho^2, and the least-squares solution reaches it.
TEST(TheFactor, Rho2IsTheLeastSumOfSquares) {
  Random random(3);
  const Rows rows = random_rows(400, 6, random);
  const SquareRootInformation f = factor_of(rows, names(6));
  const VectorXd x = Eigen::ColPivHouseholderQR<MatrixXd>(rows.A).solve(rows.b);
  EXPECT_NEAR(f.rho2(), (rows.A * x - rows.b).squaredNorm(), 1e-11);
  EXPECT_NEAR(f.residual2(x), f.rho2(), 1e-11);
  EXPECT_TRUE(near(solution(f), x, 1e-11));
}

TEST(TheFactor, MergesInAnyOrder) {
  Random random(4);
  std::vector<Rows> parts;
  for (const int count : {3, 50, 0, 200, 1}) parts.push_back(random_rows(count, 6, random));
  SquareRootInformation all(names(6));
  for (const Rows& p : parts) all.absorb(p.A, p.b);
  std::vector<size_t> order{0, 1, 2, 3, 4};
  do {
    SquareRootInformation f(names(6));
    for (const size_t k : order) f.merge(factor_of(parts[k], names(6)));
    ASSERT_TRUE(same(f, all));
  } while (std::next_permutation(order.begin(), order.end()));
}

// (a + b) + c = a + (b + c), with columns that only some have: those columns are zero in the
// others' rows.
TEST(TheFactor, MergesByTheNamesOfColumns) {
  Random random(5);
  const Rows p = random_rows(40, 3, random);
  const Rows q = random_rows(30, 3, random);
  SquareRootInformation f = factor_of(p, {"a", "b", "c"});
  f.merge(factor_of(q, {"d", "c", "a"}));
  ASSERT_EQ(f.columns(), (Names{"a", "b", "c", "d"}));
  Rows both{MatrixXd::Zero(70, 4), VectorXd(70)};
  both.A.topLeftCorner(40, 3) = p.A;
  both.A.bottomRows(30).col(3) = q.A.col(0);
  both.A.bottomRows(30).col(2) = q.A.col(1);
  both.A.bottomRows(30).col(0) = q.A.col(2);
  both.b << p.b, q.b;
  EXPECT_TRUE(same(f, factor_of(both, f.columns())));

  SquareRootInformation empty;
  empty.merge(f);
  EXPECT_TRUE(same(empty, f));
}

TEST(TheFactor, MergesTheRowsOfAnotherTimesTheWeight) {
  Random random(6);
  const Rows p = random_rows(40, 3, random);
  const Rows q = random_rows(30, 3, random);
  SquareRootInformation f = factor_of(p, names(3));
  f.merge(factor_of(q, names(3)), 0.3);
  Rows both{MatrixXd(70, 3), VectorXd(70)};
  both.A << p.A, 0.3 * q.A;
  both.b << p.b, 0.3 * q.b;
  EXPECT_TRUE(same(f, factor_of(both, names(3))));
}

TEST(TheFactor, MergedWithItselfCountsEveryRowTwice) {
  Random random(7);
  const Rows p = random_rows(40, 3, random);
  SquareRootInformation f = factor_of(p, names(3));
  f.merge(f);
  Rows twice{MatrixXd(80, 3), VectorXd(80)};
  twice.A << p.A, p.A;
  twice.b << p.b, p.b;
  EXPECT_TRUE(same(f, factor_of(twice, names(3))));
}

TEST(TheFactor, RestrictedToColumnsEqualsTheFactorOfTheseColumns) {
  Random random(8);
  const Rows p = random_rows(300, 6, random);
  const SquareRootInformation f = factor_of(p, names(6));
  for (const std::vector<int>& wanted :
       {std::vector<int>{4, 0, 2}, {5}, {0, 1, 2, 3, 4, 5}, {5, 4, 3, 2, 1, 0}}) {
    Rows some{MatrixXd(300, static_cast<Eigen::Index>(wanted.size())), p.b};
    Names columns;
    for (size_t j = 0; j < wanted.size(); ++j) {
      some.A.col(j) = p.A.col(wanted[j]);
      columns.push_back("x" + std::to_string(wanted[j]));
    }
    EXPECT_TRUE(same(f.restricted(columns), factor_of(some, columns)));
  }
  // A column that is not there is zero; none at all leaves ||b||^2.
  const SquareRootInformation g = f.restricted({"x1", "nowhere"});
  EXPECT_NEAR(g.residual2(Eigen::Vector2d(2.0, 1e9)), (2.0 * p.A.col(1) - p.b).squaredNorm(), 1e-9);
  EXPECT_NEAR(f.restricted({}).rho2(), p.b.squaredNorm(), 1e-10);
  EXPECT_EQ(f.restricted({}).rows(), 300);
}

// Rows of links near the tip have few columns, and short blocks have few rows. However blocks are merged, the factor has the
// sum of squares of all rows.
TEST(TheFactor, AddsUpFactorsOfAnyRowsAndColumns) {
  Random random(17);
  constexpr int kColumns = 136;
  const std::vector<std::pair<int, std::vector<int>>> shapes = {  // rows, and columns that are not zero
      {1, {20}}, {5, {3, 1, 2}}, {12, {30, 31, 32, 33, 34}}, {30, {0, 60, 135}}, {35, {9, 8}}, {90, {135, 0, 11}}};
  std::vector<SquareRootInformation> parts;
  Rows all{MatrixXd::Zero(173, kColumns), VectorXd(173)};
  Eigen::Index at = 0;
  for (const auto& [rows, columns] : shapes) {
    const Rows p = random_rows(rows, static_cast<int>(columns.size()), random);
    Names mine;
    for (size_t j = 0; j < columns.size(); ++j) {
      mine.push_back("x" + std::to_string(columns[j]));
      all.A.col(columns[j]).segment(at, rows) = 0.5 * p.A.col(static_cast<Eigen::Index>(j));
    }
    all.b.segment(at, rows) = 0.5 * p.b;
    parts.push_back(factor_of(p, mine).restricted(rows < 35 ? names(kColumns) : mine));
    at += rows;
  }
  std::vector<size_t> order{0, 1, 2, 3, 4, 5};
  do {
    SquareRootInformation f(names(kColumns)), some(names(kColumns / 2));
    for (const size_t k : order) f.merge(parts[k], 0.5);
    for (const size_t k : order) some.merge_known(parts[k], 0.5);
    ASSERT_TRUE(same(f, factor_of(all, names(kColumns))));
    ASSERT_TRUE(same(some, factor_of({all.A.leftCols(kColumns / 2), all.b}, names(kColumns / 2))));
  } while (std::next_permutation(order.begin() + 2, order.end()));
}

TEST(TheFactor, ChangeOfVariablesEqualsTheFactorOfTransformedRows) {
  Random random(9);
  const Rows p = random_rows(100, 5, random);
  const SquareRootInformation f = factor_of(p, names(5));
  for (const int to : {2, 5, 9}) {
    const MatrixXd T = random_rows(5, to, random).A;
    EXPECT_TRUE(same(f.transformed(T, names(to, "y")), factor_of({p.A * T, p.b}, names(to, "y"))))
        << to << " variables";
  }
}

TEST(TheFactor, ColumnNormsAreThoseOfItsRows) {
  Random random(10);
  const Rows p = random_rows(500, 4, random);
  EXPECT_TRUE(
      near(factor_of(p, names(4)).column_norms(), p.A.colwise().norm().transpose(), 1e-12 * 500));
}

// What is kept is a square of the columns, however many rows went in, and no digits are lost on the
// way.
TEST(TheFactor, SizeDoesNotGrowWithTheNumberOfRows) {
  Random random(11);
  const VectorXd truth = random.vector(4, -1, 1);
  SquareRootInformation f(names(4));
  for (int k = 0; k < 1000; ++k) {
    const MatrixXd A = random_rows(100, 4, random).A;
    f.absorb(A, A * truth);
  }
  EXPECT_EQ(f.rows(), 1e5);
  EXPECT_EQ(f.R().size(), 16);
  EXPECT_EQ(f.z().size(), 4);
  // A thousand steps of rounding, each eps ||b||: far below what normal equations leave, eps
  // ||b||^2.
  EXPECT_LT(std::sqrt(f.rho2()), 1e-13 * std::sqrt(f.rhs_norm2()) * std::sqrt(1000.0));
  EXPECT_TRUE(near(solution(f), truth, 1e-12));
}

// At a condition number of 1e8, cond^2 eps of the normal equations is 2; cond eps is 2e-8.
TEST(TheFactor, SolvesBadlyConditionedRows) {
  Random random(12);
  Rows p = random_rows(200, 3, random);
  p.A.col(2) = p.A.col(0) + 1e-8 * p.A.col(2);
  const Eigen::Vector3d truth(1.0, -2.0, 3.0);
  p.b = p.A * truth;
  const SquareRootInformation f = factor_of(p, names(3));
  EXPECT_TRUE(near(solution(f), truth, 1e-6));
}

// Each column on its own scale, over sixteen decades: R'R = A'A holds column by column.
TEST(TheFactor, IsAccurateForColumnsOverSixteenDecades) {
  Random random(14);
  Rows p = random_rows(700, 17, random);
  VectorXd scale(17);
  for (int j = 0; j < 17; ++j) scale[j] = std::pow(10.0, j - 8);
  const MatrixXd unscaled = p.A;
  p.A = p.A * scale.asDiagonal();
  const SquareRootInformation f = factor_of(p, names(17));
  const MatrixXd R = f.R() * scale.cwiseInverse().asDiagonal();
  EXPECT_TRUE(near(R.transpose() * R, unscaled.transpose() * unscaled, 1e-12 * 700));
}

// What a filter leaves at its start: columns whose squares are below the smallest double.
TEST(TheFactor, AcceptsNearlyZeroColumns) {
  Random random(17);
  Rows p = random_rows(51, 20, random);
  const VectorXd truth = random.vector(20, -1, 1);
  for (const double size : {1e-100, 1e-140, 1e-158, 1e-162, 1e-300}) {
    Rows small = p;
    small.A.middleCols(3, 9) *= size;
    const SquareRootInformation f = factor_of(small, names(20));
    EXPECT_TRUE(f.R().allFinite() && f.z().allFinite() && std::isfinite(f.rho2())) << size;
    const double direct = (small.A * truth - small.b).squaredNorm();
    EXPECT_NEAR(f.residual2(truth), direct, 1e-12 * direct);
  }
}

TEST(TheFactor, PropagatesNaN) {
  Random random(15);
  Rows p = random_rows(40, 11, random);
  p.A(17, 3) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(std::isfinite(factor_of(p, names(11)).residual2(VectorXd::Ones(11))));
}

// The kernels of all instruction sets that this processor has do the same, on rows and on a second
// triangle (whose lower left part they never read).
TEST(TheTriangle, IsTheSameOnAllInstructionSets) {
  Random random(16);
  constexpr int kColumns = 40;
  constexpr int kRows = 44;
  const long stride = triangle_stride(kColumns);
  const auto padded = [&](const MatrixXd& rows, std::vector<double>& memory) {
    memory.assign(static_cast<size_t>(kRows * stride + 8), 0.0);
    void* at = memory.data();
    size_t space = memory.size() * sizeof(double);
    auto* data = static_cast<double*>(std::align(64, 1, at, space));
    for (int i = 0; i < rows.rows(); ++i)
      for (int j = 0; j < rows.cols(); ++j) data[i * stride + j] = rows(i, j);
    return data;
  };
  const MatrixXd top = random_rows(kColumns, kColumns, random).A.triangularView<Eigen::Upper>();
  MatrixXd rows = random_rows(kRows, kColumns, random).A;
  for (const bool triangular : {false, true}) {
    if (triangular) rows = MatrixXd(rows.triangularView<Eigen::Upper>());
    const MatrixXd expected = top.transpose() * top + rows.transpose() * rows;
    std::vector<TriangleKernels> all = {triangle_kernels_baseline()};
    const InstructionSet isa = widest_instruction_set();
    if (isa >= InstructionSet::kAvx2) all.push_back(triangle_kernels_avx2());
    if (isa >= InstructionSet::kAvx512) all.push_back(triangle_kernels_avx512());
    for (const TriangleKernels& kernels : all) {
      if (kernels.update == nullptr) continue;
      std::vector<double> above;
      std::vector<double> below;
      double* R = padded(top, above);
      std::vector<int> begun;
      for (int end = kTrianglePanel; end <= kColumns; end += kTrianglePanel) begun.push_back(triangular ? end : kRows);
      kernels.update({R, padded(rows, below), stride, kColumns, begun.data()});
      MatrixXd found = MatrixXd::Zero(kColumns, kColumns);
      for (int i = 0; i < kColumns; ++i)
        for (int j = i; j < kColumns; ++j) found(i, j) = R[i * stride + j];
      EXPECT_TRUE(near(found.transpose() * found, expected, 1e-12 * kRows));
    }
  }
}

TEST(TheFactor, RefusesRowsThatDoNotFit) {
  SquareRootInformation f(names(3));
  EXPECT_THROW(f.absorb(MatrixXd::Zero(5, 2), VectorXd::Zero(5)), InvalidInput);
  EXPECT_THROW(f.absorb(MatrixXd::Zero(5, 3), VectorXd::Zero(4)), InvalidInput);
}

}  // namespace
}  // namespace veridyn
