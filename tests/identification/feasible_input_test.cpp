#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

#include "support/refusal.hpp"
#include "veridyn/identification/feasible_least_squares.hpp"

namespace veridyn {
namespace {

TEST(FeasibleLeastSquares, NamesInvalidInput) {
  const Eigen::Index n = 20;  // two bodies
  const FeasibleProblem good{MatrixXd::Identity(n, n), VectorXd::Ones(n), 0.0, {0, 10}, MatrixXd::Ones(1, n), VectorXd::Ones(1)};
  const auto refuses = [&](const std::string& part, const std::function<void(FeasibleProblem&, FeasibleOptions&)>& change) {
    FeasibleProblem problem = good;
    FeasibleOptions options;
    change(problem, options);
    EXPECT_TRUE(refuses_with(part, [&] { solve_feasible_least_squares(problem, options); }));
  };
  const double nan = std::nan("");
  refuses("no columns", [](FeasibleProblem& p, FeasibleOptions&) { p = {}; });
  for (const double rho2 : {-1.0, nan}) refuses("rho2 is", [rho2](FeasibleProblem& p, FeasibleOptions&) { p.rho2 = rho2; });
  refuses("columns, R has", [n](FeasibleProblem& p, FeasibleOptions&) { p.G = MatrixXd::Zero(p.h.size(), n - 1); });
  refuses("G or h has an entry", [nan](FeasibleProblem& p, FeasibleOptions&) { p.h[0] = nan; });
  refuses("a body starts at column -1", [](FeasibleProblem& p, FeasibleOptions&) { p.body_columns = {-1}; });
  for (const double value : {-1.0, nan}) {
    refuses("gap_tolerance", [value](FeasibleProblem&, FeasibleOptions& o) { o.gap_tolerance = value; });
    refuses("active_tolerance", [value](FeasibleProblem&, FeasibleOptions& o) { o.active_tolerance = value; });
    refuses("eigenvalue_margin", [value](FeasibleProblem&, FeasibleOptions& o) { o.eigenvalue_margin = value; });
    refuses("prior's weight", [value](FeasibleProblem&, FeasibleOptions& o) { o.entropic_prior.weight = value; });
    refuses("a negative weight or an entry", [value, n](FeasibleProblem&, FeasibleOptions& o) {
      o.quadratic_prior = {VectorXd::Constant(n, value), VectorXd::Zero(n)};
    });
  }
  refuses("max_iterations", [](FeasibleProblem&, FeasibleOptions& o) { o.max_iterations = 0; });
  refuses("body 1 is not positive definite", [](FeasibleProblem&, FeasibleOptions& o) {
    o.entropic_prior.weight = 1.0;
    o.entropic_prior.phi = {InertialVector::Zero(), InertialVector::Unit(0)};  // a point mass
  });
  refuses("weights and", [n](FeasibleProblem&, FeasibleOptions& o) {
    o.quadratic_prior = {VectorXd::Ones(n), VectorXd::Zero(n - 1)};
  });
}

}  // namespace
}  // namespace veridyn
