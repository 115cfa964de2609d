// The same small problems given to an independent solver as one linear semidefinite program:
//
//   minimise t  subject to  [ 1          R*x - z ] >= 0,   J_k(x) >= 0,   h - G*x >= 0
//                           [ (R*x-z)'   t       ]

#include <dsdp/dsdp5.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <deque>
#include <random>

#include "veridyn/identification/feasible_least_squares.hpp"

namespace veridyn {
namespace {

MatrixXd random_matrix(int rows, int columns, std::mt19937& generator) {
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, columns, [&]() { return normal(generator); });
}

// Two bodies, two other parameters; a target far from physical, so that many constraints are
// active.
FeasibleProblem random_problem(unsigned seed) {
  std::mt19937 generator(seed);
  const int n = 22;
  FeasibleProblem problem;
  problem.R = random_matrix(n, 14, generator) * random_matrix(14, n, generator);
  problem.z = 3.0 * random_matrix(n, 1, generator);
  problem.rho2 = 1.0;
  problem.body_columns = {0, 10};
  problem.G = MatrixXd::Zero(10, n);
  problem.h = VectorXd::Zero(10);
  for (int k = 0; k < 2; ++k) {
    problem.G(3 * k, 10 * k) = -1.0;  // 0.1 <= m <= 3, Ixx + Iyy + Izz <= 4
    problem.h(3 * k) = -0.1;
    problem.G(3 * k + 1, 10 * k) = 1.0;
    problem.h(3 * k + 1) = 3.0;
    for (const int j : {4, 6, 9}) problem.G(3 * k + 2, 10 * k + j) = 1.0;
    problem.h(3 * k + 2) = 4.0;
  }
  for (int j = 0; j < 2; ++j) {  // 0 <= x <= 1
    problem.G(6 + 2 * j, 20 + j) = -1.0;
    problem.G(7 + 2 * j, 20 + j) = 1.0;
    problem.h(7 + 2 * j) = 1.0;
  }
  return problem;
}

// Gives DSDP the block  S = C - sum y_i*A_i  (variable 0: C) from the lower triangles of dense
// matrices.
class DsdpBlocks {
 public:
  explicit DsdpBlocks(SDPCone cone) : cone_(cone) {}

  void set(int block, int variable, const MatrixXd& A) {
    indices_.emplace_back();
    values_.emplace_back();
    for (int i = 0; i < A.rows(); ++i) {
      for (int j = 0; j <= i; ++j) {
        if (A(i, j) == 0.0) continue;
        indices_.back().push_back(i * (i + 1) / 2 + j);
        values_.back().push_back(A(i, j));
      }
    }
    if (indices_.back().empty()) return;
    ASSERT_EQ(0, SDPConeSetASparseVecMat(cone_, block, variable, static_cast<int>(A.rows()), 1.0, 0,
                                         indices_.back().data(), values_.back().data(),
                                         static_cast<int>(indices_.back().size())));
  }

 private:
  SDPCone cone_;
  std::deque<std::vector<int>> indices_;  // DSDP keeps the pointers
  std::deque<std::vector<double>> values_;
};

MatrixXd bordered(const VectorXd& last_column, double corner, double diagonal) {
  const auto n = last_column.size();
  MatrixXd A = diagonal * MatrixXd::Identity(n + 1, n + 1);
  A.col(n).head(n) = last_column;
  A.row(n).head(n) = last_column.transpose();
  A(n, n) = corner;
  return A;
}

double dsdp_objective(const FeasibleProblem& problem) {
  const int n = static_cast<int>(problem.R.cols());
  const int bodies = static_cast<int>(problem.body_columns.size());
  DSDP dsdp;
  SDPCone cone;
  EXPECT_EQ(0, DSDPCreate(n + 1, &dsdp));
  EXPECT_EQ(0, DSDPSetDualObjective(dsdp, n + 1, -1.0));  // maximise -t
  EXPECT_EQ(0, DSDPCreateSDPCone(dsdp, 2 + bodies, &cone));
  DsdpBlocks blocks(cone);
  const int rows = static_cast<int>(problem.R.rows());
  SDPConeSetBlockSize(cone, 0, rows + 1);
  SDPConeSetBlockSize(cone, 1, static_cast<int>(problem.h.size()));
  blocks.set(0, 0, bordered(-problem.z, 0.0, 1.0));
  blocks.set(0, n + 1, -bordered(VectorXd::Zero(rows), 1.0, 0.0));
  blocks.set(1, 0, problem.h.asDiagonal());
  for (int j = 0; j < n; ++j) {
    blocks.set(0, j + 1, -bordered(problem.R.col(j), 0.0, 0.0));
    blocks.set(1, j + 1, problem.G.col(j).asDiagonal());
  }
  for (int k = 0; k < bodies; ++k) {
    SDPConeSetBlockSize(cone, 2 + k, 4);
    for (int j = 0; j < 10; ++j) {
      blocks.set(2 + k, problem.body_columns[k] + j + 1, -pseudo_inertia(InertialVector::Unit(j)));
    }
  }
  DSDPSetGapTolerance(dsdp, 1e-9);
  EXPECT_EQ(0, DSDPSetup(dsdp));
  EXPECT_EQ(0, DSDPSolve(dsdp));
  EXPECT_EQ(0, DSDPComputeX(dsdp));
  DSDPTerminationReason reason;
  DSDPStopReason(dsdp, &reason);
  EXPECT_EQ(reason, DSDP_CONVERGED);
  std::vector<double> y(n + 1);
  DSDPGetY(dsdp, y.data(), n + 1);
  DSDPDestroy(dsdp);
  return y[n] + problem.rho2;
}

TEST(FeasibleLeastSquares, AgreesWithAnIndependentSolver) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const FeasibleProblem problem = random_problem(seed);
    const FeasibleResult result = solve_feasible_least_squares(problem);
    ASSERT_EQ(result.status, FeasibleStatus::kOptimal) << result.report();
    EXPECT_FALSE(result.active_bodies.empty());
    const double expected = dsdp_objective(problem);
    EXPECT_NEAR(result.objective, expected, 1e-5 * expected) << "seed " << seed;
  }
}

}  // namespace
}  // namespace veridyn
