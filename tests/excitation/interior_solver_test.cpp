// The solver on problems whose answers are known.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "excitation/solvers/nonlinear_program.hpp"
#include "excitation/solvers/sparse_rows.hpp"
#include "support/near.hpp"
#include "support/random.hpp"

namespace veridyn {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The barrier shrinks by a tenth with each iteration, from 1e-2 to the tolerance of 1e-8: 131 of
// them. Steps that are right need hardly more.
constexpr int kPrompt = 140;

// All from functions; the Jacobian is dense.
struct Problem final : NonlinearProgram {
  int count = 0;
  std::function<double(const VectorXd&)> f;
  std::function<VectorXd(const VectorXd&)> slope, c;
  std::function<MatrixXd(const VectorXd&)> J;
  VectorXd low, high;
  std::vector<std::pair<int, int>> entries;

  int variables() const override { return count; }
  double objective(const VectorXd& x) override { return f(x); }
  VectorXd gradient(const VectorXd& x) override { return slope(x); }
  const VectorXd& lower() const override { return low; }
  const VectorXd& upper() const override { return high; }
  VectorXd constraints(const VectorXd& x) override { return c(x); }
  const std::vector<std::pair<int, int>>& pattern() const override { return entries; }
  VectorXd jacobian(const VectorXd& x) override {
    const MatrixXd all = J(x);
    VectorXd out(entries.size());
    for (size_t e = 0; e < entries.size(); ++e)
      out[static_cast<Eigen::Index>(e)] = all(entries[e].first, entries[e].second);
    return out;
  }
  void fill_pattern() {
    for (int r = 0; r < low.size(); ++r) {
      for (int k = 0; k < count; ++k) entries.emplace_back(r, k);
    }
  }
};

SolverOptions exact() {
  SolverOptions options;
  options.tolerance = 1e-8;
  return options;
}

// The nearest point of a box and a half space, from inside and from far outside of them.
TEST(InteriorPoint, FindsTheNearestPointOfAPolytope) {
  Problem p;
  p.count = 3;
  const VectorXd centre = Eigen::Vector3d(2.0, 2.0, -0.5);
  p.f = [&](const VectorXd& x) { return 0.5 * (x - centre).squaredNorm(); };
  p.slope = [&](const VectorXd& x) { return VectorXd(x - centre); };
  MatrixXd A(4, 3);
  A << 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 0;
  p.c = [&](const VectorXd& x) { return VectorXd(A * x); };
  p.J = [&](const VectorXd&) { return A; };
  p.low = Eigen::Vector4d(-1, -1, -1, -kInfinity);
  p.high = Eigen::Vector4d(1, 1, 1, 1.5);
  p.fill_pattern();
  for (const VectorXd& start :
       {VectorXd(Eigen::Vector3d(0, 0, 0)), VectorXd(Eigen::Vector3d(9, -7, 5))}) {
    const SolverResult r = solve_with_interior_point(p, start, exact());
    EXPECT_TRUE(r.converged);
    EXPECT_LE(r.iterations, kPrompt);
    EXPECT_TRUE(near(r.x, Eigen::Vector3d(0.75, 0.75, -0.5), 1e-5));
  }
}

// Rosenbrock's valley within a disc: no step of a convex model fits, and the answer is on the edge.
// There the gradient is a negative multiple of the disc's normal.
TEST(InteriorPoint, MeetsTheConditionsOfKarushKuhnAndTucker) {
  Problem p;
  p.count = 2;
  p.f = [](const VectorXd& x) {
    return std::pow(1 - x[0], 2) + 100 * std::pow(x[1] - x[0] * x[0], 2);
  };
  p.slope = [](const VectorXd& x) {
    const double v = x[1] - x[0] * x[0];
    return VectorXd(Eigen::Vector2d(-2 * (1 - x[0]) - 400 * x[0] * v, 200 * v));
  };
  p.c = [](const VectorXd& x) { return VectorXd::Constant(1, x.squaredNorm()); };
  p.J = [](const VectorXd& x) { return MatrixXd(2.0 * x.transpose()); };
  p.low = VectorXd::Constant(1, -kInfinity);
  p.high = VectorXd::Constant(1, 1.0);
  p.fill_pattern();
  SolverOptions options = exact();
  options.iterations = 500;
  const SolverResult r = solve_with_interior_point(p, Eigen::Vector2d(-0.5, 0.5), options);
  EXPECT_LE(r.iterations, kPrompt);
  EXPECT_NEAR(r.x.squaredNorm(), 1.0, 1e-6);
  const VectorXd slope = p.slope(r.x);
  const double pressure = -slope.dot(r.x) / r.x.squaredNorm();
  EXPECT_GT(pressure, 0.0);
  EXPECT_LT((slope + pressure * r.x).norm(), 1e-4);
}

TEST(InteriorPoint, EndsWhenStopReturnsTrue) {
  Problem p;
  p.count = 1;
  p.f = [](const VectorXd& x) { return x[0]; };
  p.slope = [](const VectorXd&) { return VectorXd::Ones(1); };
  p.c = [](const VectorXd& x) { return x; };
  p.J = [](const VectorXd&) { return MatrixXd::Ones(1, 1); };
  p.low = VectorXd::Constant(1, 0.0);
  p.high = VectorXd::Constant(1, 1.0);
  p.fill_pattern();
  SolverOptions options = exact();
  int asked = 0;
  options.stop = [&asked] { return ++asked > 3; };
  const SolverResult r = solve_with_interior_point(p, VectorXd::Constant(1, 0.5), options);
  EXPECT_EQ(r.iterations, 3);
  EXPECT_FALSE(r.converged);
}

TEST(SparseRows, AgreeWithTheDenseMatrix) {
  const std::vector<std::pair<int, int>> pattern = {{2, 0}, {0, 1}, {2, 1}, {0, 3}, {2, 3}, {3, 2}};
  Random random(4);
  const VectorXd values = random.vector(static_cast<int>(pattern.size()), -1.0, 1.0);
  MatrixXd J = MatrixXd::Zero(4, 4);
  for (size_t e = 0; e < pattern.size(); ++e)
    J(pattern[e].first, pattern[e].second) = values[static_cast<Eigen::Index>(e)];
  SparseRows rows(pattern, 4);
  rows.set(values);
  const VectorXd x = random.vector(4, -1.0, 1.0);
  EXPECT_TRUE(near(rows.times(x), J * x, 1e-15));
  EXPECT_TRUE(near(rows.transposed_times(x, 4), J.transpose() * x, 1e-15));
  MatrixXd A = MatrixXd::Zero(4, 4);
  rows.add_normal(x, A);
  const MatrixXd normal = J.transpose() * x.asDiagonal() * J;
  EXPECT_TRUE(near(MatrixXd(A.triangularView<Eigen::Lower>()),
                   MatrixXd(normal.triangularView<Eigen::Lower>()), 1e-15));
}

}  // namespace
}  // namespace veridyn
