#include "veridyn/identification/feasible_least_squares.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "identification/random_bodies.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

using Eigen::Matrix4d;

// ---- problems
// ----------------------------------------------------------------------------------------

void add_row(FeasibleProblem& problem, const VectorXd& row, double bound) {
  problem.G.conservativeResize(problem.G.rows() + 1, problem.R.cols());
  problem.h.conservativeResize(problem.h.size() + 1);
  problem.G.bottomRows(1) = row.transpose();
  problem.h(problem.h.size() - 1) = bound;
}

void add_bounds(FeasibleProblem& problem, int column, double lower, double upper) {
  const VectorXd unit = VectorXd::Unit(problem.R.cols(), column);
  add_row(problem, -unit, -lower);
  add_row(problem, unit, upper);
}

struct Shape {
  int bodies = 2;
  int others = 3;
  int rank = 15;
  double noise = 1.0;
};

// True bodies and other parameters, a regressor of the given rank, noise that pushes the fit
// outside. Mass and the sum of the moments of inertia are bounded, so that every parameter is.
FeasibleProblem random_problem(const Shape& shape, unsigned seed) {
  std::mt19937 generator(seed);
  const int n = 10 * shape.bodies + shape.others;
  FeasibleProblem problem;
  const MatrixXd left = random_matrix(n, shape.rank, generator);
  problem.R = left * random_matrix(shape.rank, n, generator);
  VectorXd truth(n);
  for (int k = 0; k < shape.bodies; ++k) {
    problem.body_columns.push_back(10 * k);
    truth.segment<10>(10 * k) = random_body(generator);
  }
  truth.tail(shape.others) =
      random_matrix(shape.others, 1, generator).cwiseAbs().cwiseMax(0.1).cwiseMin(1.4);
  problem.z = problem.R * truth + shape.noise * random_matrix(n, 1, generator);
  problem.rho2 = 3.0;
  for (int k = 0; k < shape.bodies; ++k) {
    add_bounds(problem, 10 * k, 0.5, 4.0);
    VectorXd inertias = VectorXd::Zero(n);
    for (const int j : {4, 6, 9}) inertias(10 * k + j) = 1.0;
    add_row(problem, inertias, 2.0);
  }
  for (int j = 10 * shape.bodies; j < n; ++j) add_bounds(problem, j, 0.0, 1.5);
  return problem;
}

double unconstrained_objective(const FeasibleProblem& problem) {
  const VectorXd x = problem.R.completeOrthogonalDecomposition().solve(problem.z);
  return (problem.R * x - problem.z).squaredNorm() + problem.rho2;
}

void expect_optimal(const FeasibleProblem& problem, const FeasibleResult& result) {
  EXPECT_EQ(result.status, FeasibleStatus::kOptimal) << result.report();
  EXPECT_TRUE(result.feasible);
  EXPECT_LE(result.lower_bound, result.cost);
  for (const int column : problem.body_columns) {
    EXPECT_GT(smallest_eigenvalue(pseudo_inertia(result.x.segment<10>(column))), 0.0);
  }
  if (problem.h.size() > 0) {
    EXPECT_GT((problem.h - problem.G * result.x).minCoeff(), 0.0);
  }
  // Up to the rounding of the two sums of squares.
  const double rounding = 1e-13 * (problem.z.squaredNorm() + problem.rho2);
  EXPECT_GE(result.objective, unconstrained_objective(problem) - rounding);
}

MatrixXd read_csv(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::vector<double> values;
  Eigen::Index rows = 0;
  for (std::string line; std::getline(file, line); ++rows) {
    std::istringstream fields(line);
    for (std::string field; std::getline(fields, field, ',');) values.push_back(std::stod(field));
  }
  const Eigen::Index columns = rows > 0 ? static_cast<Eigen::Index>(values.size()) / rows : 0;
  return Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
      values.data(), rows, columns);
}

class ReferenceInstance : public testing::Test {
 protected:
  void SetUp() override {
    const std::filesystem::path folder = VERIDYN_SOURCE_DIR "/../shared/reference/sdp";
    if (!std::filesystem::exists(folder / "R.csv"))
      GTEST_SKIP() << "no reference instance at " << folder;
    problem_.R = read_csv(folder / "R.csv");
    problem_.z = read_csv(folder / "b.csv");
    problem_.G = read_csv(folder / "G.csv");
    problem_.h = read_csv(folder / "h.csv");
    problem_.rho2 = 37884.30719356053;  // meta.json
    for (int k = 0; k < 10; ++k) problem_.body_columns.push_back(10 * k);
  }

  FeasibleProblem problem_;
};

// ---- optimality
// --------------------------------------------------------------------------------------

TEST_F(ReferenceInstance, ReachesTheReferenceObjective) {
  // 38040.3662628487: primal-dual method in 80-bit arithmetic, confirmed by cvxopt to 2e-12.
  const FeasibleResult result = solve_feasible_least_squares(problem_);
  expect_optimal(problem_, result);
  EXPECT_NEAR(result.objective, 38040.3662628487, 1e-8 * 38040.0);
  EXPECT_LE(result.lower_bound, 38040.3662628487 * (1.0 + 1e-13));
  EXPECT_LE(result.duality_gap, 1e-9);
  EXPECT_LE(result.iterations, 25);
  EXPECT_EQ(result.certificate,
            Certificate::kNoBox);  // nothing bounds the moments of inertia from above
}

TEST_F(ReferenceInstance, TheCertificateIsRigorousIfInertiasAreBounded) {
  for (const int column : problem_.body_columns) {
    VectorXd inertias = VectorXd::Zero(115);
    for (const int j : {4, 6, 9}) inertias(column + j) = 1.0;
    add_row(problem_, inertias, 100.0);
  }
  for (int j = 102; j < 115; j += 3) add_bounds(problem_, j, -100.0, 100.0);
  const FeasibleResult result = solve_feasible_least_squares(problem_);
  expect_optimal(problem_, result);
  EXPECT_NEAR(result.objective, 38040.3662628487, 1e-8 * 38040.0);
  EXPECT_EQ(result.certificate, Certificate::kRigorous) << result.report();
}

// Normal equations of a triangle are summed otherwise than those of any rows, and with so many
// variables the corrector is repeated (without: 13 iterations).
TEST(FeasibleLeastSquares, ATriangularFactorGivesTheObjectiveOfItsRows) {
  const FeasibleProblem rows = random_problem({22, 5, 225, 2.0}, 5);
  const Eigen::HouseholderQR<MatrixXd> qr(rows.R);
  FeasibleProblem triangle = rows;
  triangle.R = qr.matrixQR().triangularView<Eigen::Upper>();
  triangle.z = qr.householderQ().transpose() * rows.z;
  const FeasibleResult a = solve_feasible_least_squares(rows);
  const FeasibleResult b = solve_feasible_least_squares(triangle);
  expect_optimal(rows, a);
  expect_optimal(triangle, b);
  EXPECT_NEAR(a.objective, b.objective, 1e-8 * a.objective);
  EXPECT_LE(b.iterations, 11);
}

// Stationarity and complementarity, in units of the largest term; multipliers in their cones.
TEST(FeasibleLeastSquares, MeetsTheOptimalityConditions) {
  for (unsigned seed = 1; seed <= 100; ++seed) {
    const FeasibleProblem problem = random_problem({3, 4, 22, 2.0}, seed);
    FeasibleOptions options;
    options.gap_tolerance = 1e-10;
    const FeasibleResult result = solve_feasible_least_squares(problem, options);
    expect_optimal(problem, result);
    EXPECT_EQ(result.certificate, Certificate::kRigorous);

    VectorXd gradient = 2.0 * problem.R.transpose() * (problem.R * result.x - problem.z);
    double scale =
        (problem.R.cwiseAbs().transpose() * (problem.R * result.x - problem.z).cwiseAbs())
            .maxCoeff();
    gradient += problem.G.transpose() * result.row_multipliers;
    double products = result.row_multipliers.dot(problem.h - problem.G * result.x);
    EXPECT_GE(result.row_multipliers.minCoeff(), 0.0);
    for (size_t k = 0; k < problem.body_columns.size(); ++k) {
      const Matrix4d& Z = result.body_multipliers[k];
      EXPECT_GE(smallest_eigenvalue(Z), -1e-12 * Z.norm());
      const auto phi = result.x.segment<10>(problem.body_columns[k]);
      products += pseudo_inertia(phi).cwiseProduct(Z).sum();
      gradient.segment<10>(problem.body_columns[k]) -= pseudo_inertia_adjoint(Z);
      scale = std::max(scale, Z.norm());
    }
    EXPECT_LT(gradient.cwiseAbs().maxCoeff(), 1e-8 * scale) << "seed " << seed;
    EXPECT_LT(products, 1e-10 * result.objective) << "seed " << seed;
  }
}

TEST(FeasibleLeastSquares, EqualsLeastSquaresWhereNothingIsActive) {
  const FeasibleProblem problem = random_problem({2, 3, 23, 1e-4}, 3);
  const FeasibleResult result = solve_feasible_least_squares(problem);
  expect_optimal(problem, result);
  EXPECT_NEAR(result.objective, unconstrained_objective(problem), 1e-9 * result.objective);
  EXPECT_TRUE(result.active_rows.empty());
  EXPECT_TRUE(result.active_bodies.empty());
}

TEST(FeasibleLeastSquares, ProjectsAnImpossibleBodyOntoAPointMass) {
  // Identity regressor over J: the nearest positive semidefinite matrix to -1 + 5*r*r' has rank
  // one.
  const Eigen::Vector4d r = Eigen::Vector4d(0.3, -0.2, 0.1, 0.9).normalized();
  const Matrix4d target = -Matrix4d::Identity() + 5.0 * r * r.transpose();
  FeasibleProblem problem;
  problem.R.resize(16, 10);
  for (int j = 0; j < 10; ++j) {
    const Matrix4d column = pseudo_inertia(InertialVector::Unit(j));
    problem.R.col(j) = Eigen::Map<const VectorXd>(column.data(), 16);
  }
  problem.z = Eigen::Map<const VectorXd>(target.data(), 16);
  problem.body_columns = {0};
  const FeasibleResult result = solve_feasible_least_squares(problem);
  expect_optimal(problem, result);
  EXPECT_NEAR(result.objective, 3.0, 3.0 * 2e-9);  // the three eigenvalues -1 go to 0; 4 stays
  EXPECT_LT((pseudo_inertia(result.x) - 4.0 * r * r.transpose()).norm(), 1e-4);
  ASSERT_EQ(result.active_bodies.size(), 1u);
  EXPECT_NEAR(result.active_bodies[0].eigenvalues(3), 4.0, 1e-4);
  // Gradient 2*(J - target) = Z: twice the projector onto the complement of r.
  const Matrix4d Z = 2.0 * (Matrix4d::Identity() - r * r.transpose());
  EXPECT_LT((result.body_multipliers[0] - Z).norm(), 1e-3);
}

TEST(FeasibleLeastSquares, WithoutBodiesIsNonNegativeLeastSquares) {
  FeasibleProblem problem;
  problem.R = MatrixXd::Identity(3, 3);
  problem.z = Eigen::Vector3d(1.0, -2.0, 3.0);
  problem.G = -MatrixXd::Identity(3, 3);
  problem.h = VectorXd::Zero(3);
  const FeasibleResult result = solve_feasible_least_squares(problem);
  expect_optimal(problem, result);
  EXPECT_NEAR(result.objective, 4.0, 1e-8);
  EXPECT_LT((result.x - Eigen::Vector3d(1.0, 0.0, 3.0)).norm(), 1e-4);
  ASSERT_EQ(result.active_rows.size(), 1u);
  EXPECT_EQ(result.active_rows[0].row, 1);
  EXPECT_NEAR(result.active_rows[0].multiplier, 4.0, 1e-4);  // d/dh (h + 2)^2 = 4, with sign
}

TEST(FeasibleLeastSquares, WithoutConstraintsIsLeastSquares) {
  FeasibleProblem problem = random_problem({0, 12, 7, 1.0}, 8);
  problem.G.resize(0, 0);
  problem.h.resize(0);
  const FeasibleResult result = solve_feasible_least_squares(problem);
  expect_optimal(problem, result);
  EXPECT_NEAR(result.objective, unconstrained_objective(problem), 1e-9 * result.objective);
}

// ---- invariance and awkward data
// ---------------------------------------------------------------------

TEST(FeasibleLeastSquares, TheObjectiveDoesNotDependOnUnits) {
  // Friction in other units: columns times 1e-6 .. 1e3, bounds to match.
  const FeasibleProblem problem = random_problem({2, 4, 15, 2.0}, 4);
  const FeasibleResult expected = solve_feasible_least_squares(problem);
  FeasibleProblem other = problem;
  const double units[] = {1e-6, 1e-3, 1.0, 1e3};
  for (int j = 0; j < 4; ++j) {
    other.R.col(20 + j) *= units[j];
    other.G.col(20 + j) *= units[j];
  }
  const FeasibleResult result = solve_feasible_least_squares(other);
  expect_optimal(other, result);
  EXPECT_NEAR(result.objective, expected.objective, 3e-9 * expected.objective);

  // Metres to millimetres and kilograms to grams: h by 1e6, inertia by 1e9.
  other = problem;
  for (const int column : problem.body_columns) {
    const double scale[] = {1e3, 1e6, 1e6, 1e6, 1e9, 1e9, 1e9, 1e9, 1e9, 1e9};
    for (int j = 0; j < 10; ++j) {
      other.R.col(column + j) /= scale[j];
      other.G.col(column + j) /= scale[j];
    }
  }
  const FeasibleResult grams = solve_feasible_least_squares(other);
  expect_optimal(other, grams);
  EXPECT_NEAR(grams.objective, expected.objective, 3e-9 * expected.objective);
}

TEST(FeasibleLeastSquares, TheObjectiveScalesWithTheSumOfSquares) {
  for (const double scale : {1e-6, 1e6}) {
    FeasibleProblem problem = random_problem({2, 3, 15, 2.0}, 9);
    const FeasibleResult expected = solve_feasible_least_squares(problem);
    problem.R *= scale;
    problem.z *= scale;
    problem.rho2 *= scale * scale;
    const FeasibleResult result = solve_feasible_least_squares(problem);
    expect_optimal(problem, result);
    EXPECT_NEAR(result.objective / (scale * scale), expected.objective, 3e-9 * expected.objective);
  }
}

// Without bounds the cost may have no minimum: a mass that no row sees lets its first moments grow.
TEST(FeasibleLeastSquares, MeetsTheOptimalityConditionsWithUnidentifiableParameters) {
  int minima = 0;
  for (unsigned seed = 1; seed <= 30; ++seed) {
    FeasibleProblem problem = random_problem({2, 4, 15, 2.0}, seed);
    for (const int j : {0, 4, 5, 6, 7, 8, 20}) problem.R.col(j).setZero();
    problem.R.col(21) = problem.R.col(22);
    problem.z += problem.R.col(22);
    expect_optimal(problem, solve_feasible_least_squares(problem));

    FeasibleProblem no_bounds = problem;
    no_bounds.G.resize(0, 0);
    no_bounds.h.resize(0);
    const FeasibleResult result = solve_feasible_least_squares(no_bounds);
    EXPECT_EQ(result.certificate, Certificate::kNoBox);
    if (result.status == FeasibleStatus::kOptimal) {
      ++minima;
      expect_optimal(no_bounds, result);
      continue;
    }
    EXPECT_EQ(result.status, FeasibleStatus::kNotConverged) << "seed " << seed;
    EXPECT_TRUE(result.feasible) << "seed " << seed;
    EXPECT_FALSE(result.unbounded_columns.empty()) << "seed " << seed;
    EXPECT_GT(result.x.cwiseAbs().maxCoeff(), 1e6) << "seed " << seed;
  }
  EXPECT_GE(minima, 10);

  FeasibleProblem problem = random_problem({2, 4, 15, 2.0}, 12);
  problem.G.resize(0, 0);
  problem.h.resize(0);
  problem.R.setZero();
  const FeasibleResult nothing = solve_feasible_least_squares(problem);
  expect_optimal(problem, nothing);
  EXPECT_DOUBLE_EQ(nothing.objective, problem.z.squaredNorm() + problem.rho2);
}

// Rows weighed over twelve orders, columns that are equal, that depend on each other or that are zero, up
// to sixty bodies, with and without a box: a possible optimum, or a status with its reason.
TEST(FeasibleLeastSquares, IsFeasibleOrReportsTheReason) {
  int optimal = 0;
  std::vector<Shape> shapes;
  for (int k = 0; k < 30; ++k) shapes.push_back({1 + k % 4, 3, 4 + k % 11, std::pow(10.0, k % 5 - 2)});
  shapes.push_back({60, 60, 400, 1.0});
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    FeasibleProblem problem = random_problem(shapes[k], 100 + static_cast<unsigned>(k));
    const double weight = std::pow(10.0, static_cast<double>(k % 13) - 6.0);
    problem.R *= weight;
    problem.z *= weight;
    problem.rho2 *= weight * weight;
    if (k % 3 == 0) problem.R.col(1) = problem.R.col(0);
    if (k % 4 == 0) problem.R.col(5).setZero();
    if (k % 5 == 0) problem.R.col(2) = problem.R.col(3) - 2.0 * problem.R.col(4);
    if (k % 7 == 6) {
      problem.G.resize(0, 0);
      problem.h.resize(0);
    }
    const FeasibleResult result = solve_feasible_least_squares(problem);
    SCOPED_TRACE(text("problem ", k, ": ", result.report()));
    if (result.status == FeasibleStatus::kOptimal) {
      expect_optimal(problem, result);
      ++optimal;
      continue;
    }
    EXPECT_FALSE(result.report().empty());
    EXPECT_NE(result.status, FeasibleStatus::kInfeasible);  // the true bodies are possible
  }
  EXPECT_GE(optimal, 25);
}

TEST(FeasibleLeastSquares, FitsExactDataExactly) {
  FeasibleProblem problem = random_problem({2, 3, 15, 0.0}, 2);
  problem.rho2 = 0.0;
  const FeasibleResult result = solve_feasible_least_squares(problem);
  expect_optimal(problem, result);
  EXPECT_LT(result.objective,
            1e-14 * problem.z.squaredNorm());  // gap_tolerance * floor = 1e-15*||z||^2
}

TEST(FeasibleLeastSquares, ReportsInfeasibleProblems) {
  FeasibleProblem problem = random_problem({2, 3, 15, 1.0}, 7);
  FeasibleProblem contradiction = problem;
  add_row(contradiction, VectorXd::Unit(23, 20), -0.5);  // x_20 >= 0 stands already
  FeasibleResult result = solve_feasible_least_squares(contradiction);
  EXPECT_EQ(result.status, FeasibleStatus::kInfeasible) << result.report();
  EXPECT_EQ(result.certificate, Certificate::kRigorous);
  EXPECT_FALSE(result.feasible);

  FeasibleProblem unphysical = problem;  // Ixx above what the triangle inequality allows
  add_bounds(unphysical, 4, 0.5, 0.6);
  add_bounds(unphysical, 6, 0.1, 0.2);
  add_bounds(unphysical, 9, 0.1, 0.2);
  EXPECT_EQ(solve_feasible_least_squares(unphysical).status, FeasibleStatus::kInfeasible);
  FeasibleOptions options;
  options.condition = PhysicalCondition::kPrincipalMoments;
  EXPECT_EQ(solve_feasible_least_squares(unphysical, options).status, FeasibleStatus::kOptimal);

  FeasibleProblem pinned = problem;
  add_bounds(pinned, 21, 0.75, 0.75);
  result = solve_feasible_least_squares(pinned);
  EXPECT_EQ(result.status, FeasibleStatus::kNoInterior) << result.report();
  EXPECT_FALSE(result.feasible);
}

// ---- options
// -----------------------------------------------------------------------------------------

TEST(FeasibleLeastSquares, WeakerConditionsNeverIncreaseTheObjective) {
  for (unsigned seed = 20; seed < 26; ++seed) {
    const FeasibleProblem problem = random_problem({2, 3, 20, 3.0}, seed);
    FeasibleOptions options;
    const FeasibleResult full = solve_feasible_least_squares(problem, options);
    options.condition = PhysicalCondition::kPrincipalMoments;
    const FeasibleResult weaker = solve_feasible_least_squares(problem, options);
    options.condition = PhysicalCondition::kNone;
    const FeasibleResult none = solve_feasible_least_squares(problem, options);
    ASSERT_EQ(full.status, FeasibleStatus::kOptimal);
    ASSERT_EQ(weaker.status, FeasibleStatus::kOptimal);
    ASSERT_EQ(none.status, FeasibleStatus::kOptimal);
    EXPECT_LE(weaker.lower_bound, full.objective);
    EXPECT_LE(none.lower_bound, weaker.objective);
    for (const int column : problem.body_columns) {
      EXPECT_GT(smallest_eigenvalue(principal_moment_matrix(weaker.x.segment<10>(column))), 0.0);
    }
  }
}

TEST(FeasibleLeastSquares, KeepsTheEigenvalueMargin) {
  const FeasibleProblem problem = random_problem({2, 3, 20, 3.0}, 21);
  FeasibleOptions options;
  options.eigenvalue_margin = 1e-3;
  const FeasibleResult result = solve_feasible_least_squares(problem, options);
  expect_optimal(problem, result);
  EXPECT_FALSE(result.active_bodies.empty());
  for (const int column : problem.body_columns) {
    EXPECT_GT(smallest_eigenvalue(pseudo_inertia(result.x.segment<10>(column))), 1e-3);
  }
}

TEST(FeasibleLeastSquares, AHeavyEntropicPriorDeterminesTheSolution) {
  const FeasibleProblem problem = random_problem({2, 3, 15, 1.0}, 30);
  std::mt19937 generator(31);
  FeasibleOptions options;
  options.entropic_prior.weight = 1e10;
  options.entropic_prior.phi = {random_body(generator), random_body(generator)};
  const FeasibleResult result = solve_feasible_least_squares(problem, options);
  expect_optimal(problem, result);
  for (int k = 0; k < 2; ++k) {
    // First order: x - prior = gradient of the squares / weight.
    const InertialVector prior = options.entropic_prior.phi[k];
    EXPECT_LT((result.x.segment<10>(10 * k) - prior).norm(), 1e-5 * prior.norm());
  }
}

// Stationarity with both priors, their gradients written down directly.
TEST(FeasibleLeastSquares, PriorsEnterTheOptimalityConditions) {
  const FeasibleProblem problem = random_problem({2, 3, 15, 1.0}, 33);
  std::mt19937 generator(34);
  FeasibleOptions options;
  options.gap_tolerance = 1e-11;
  options.entropic_prior.weight = 0.7;
  options.entropic_prior.phi = {random_body(generator), random_body(generator)};
  options.quadratic_prior.weight = VectorXd::LinSpaced(23, 0.0, 1.0);
  options.quadratic_prior.x = random_matrix(23, 1, generator);
  const FeasibleResult result = solve_feasible_least_squares(problem, options);
  expect_optimal(problem, result);
  const VectorXd from_prior = result.x - options.quadratic_prior.x;
  VectorXd gradient = 2.0 * problem.R.transpose() * (problem.R * result.x - problem.z) +
                      2.0 * options.quadratic_prior.weight.cwiseProduct(from_prior) +
                      problem.G.transpose() * result.row_multipliers;
  double cost = result.objective + options.quadratic_prior.weight.dot(from_prior.cwiseAbs2());
  for (int k = 0; k < 2; ++k) {
    const Matrix4d J = pseudo_inertia(result.x.segment<10>(10 * k));
    const Matrix4d J0 = pseudo_inertia(options.entropic_prior.phi[k]);
    gradient.segment<10>(10 * k) += 0.7 * pseudo_inertia_adjoint(J0.inverse() - J.inverse());
    cost += 0.7 * entropic_divergence(J, J0);
  }
  EXPECT_LT(gradient.norm(), 1e-4 * (problem.R.transpose() * problem.z).norm());
  EXPECT_NEAR(result.cost, cost, 1e-12 * cost);
}

TEST(FeasibleLeastSquares, RejectsInvalidProblems) {
  const FeasibleProblem good = random_problem({2, 3, 15, 1.0}, 1);
  FeasibleProblem problem = good;
  problem.z.conservativeResize(5);
  EXPECT_THROW(solve_feasible_least_squares(problem), InvalidInput);
  problem = good;
  problem.body_columns = {0, 5};
  EXPECT_THROW(solve_feasible_least_squares(problem), InvalidInput);
  problem.body_columns = {14};
  EXPECT_THROW(solve_feasible_least_squares(problem), InvalidInput);
  problem = good;
  problem.R(0, 0) = std::nan("");
  EXPECT_THROW(solve_feasible_least_squares(problem), InvalidInput);
  problem = good;
  problem.h.conservativeResize(1);
  EXPECT_THROW(solve_feasible_least_squares(problem), InvalidInput);
  FeasibleOptions options;
  options.entropic_prior.weight = 1.0;
  EXPECT_THROW(solve_feasible_least_squares(good, options), InvalidInput);
}

}  // namespace
}  // namespace veridyn
