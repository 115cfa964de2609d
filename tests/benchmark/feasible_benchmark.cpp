#include <benchmark/benchmark.h>

#include <cmath>

#include "support/random.hpp"
#include "veridyn/identification/feasible_least_squares.hpp"
#include "veridyn/identification/pseudo_inertia.hpp"

// The feasible fit alone: so many bodies whose parameters are seen through dense rows with noise, a
// third of the directions hardly at all, as recordings do; certified to 1e-8.

namespace veridyn {
namespace {

FeasibleProblem problem_of(int bodies) {
  constexpr double kHeaviest = 10.0;  // [kg]
  constexpr double kReach = 0.5;      // [m]
  Random random(static_cast<unsigned>(bodies));
  const int n = kBodyParameters * bodies;
  FeasibleProblem problem;
  problem.R = MatrixXd::Zero(n, n);
  for (int i = 0; i < n; ++i) {
    const double size = i % 3 == 2 ? 1e-3 : 1.0;
    problem.R(i, i) = size;
    for (int j = i + 1; j < n; ++j) problem.R(i, j) = size * random.in(-1, 1) / std::sqrt(n);
  }
  VectorXd truth(n);
  problem.G = MatrixXd::Zero(2 * bodies, n);
  problem.h = VectorXd::Zero(2 * bodies);
  for (int b = 0; b < bodies; ++b) {
    const int first = kBodyParameters * b;
    problem.body_columns.push_back(first);
    truth.segment<kBodyParameters>(first) = random.body();
    problem.G(2 * b, first) = 1.0;
    problem.h[2 * b] = kHeaviest;
    problem.G(2 * b + 1, first) = -4.0 * kReach * kReach;
    for (const int c : {4, 6, 9}) problem.G(2 * b + 1, first + c) = 0.5;
  }
  problem.z = problem.R * truth + 0.01 * random.vector(n, -1, 1);
  return problem;
}

void feasible_fit(benchmark::State& state) {
  const FeasibleProblem problem = problem_of(static_cast<int>(state.range(0)));
  FeasibleOptions options;
  options.gap_tolerance = 1e-8;
  int iterations = 0;
  for (auto _ : state) {
    const FeasibleResult result = solve_feasible_least_squares(problem, options);
    if (result.status != FeasibleStatus::kOptimal) state.SkipWithError("not certified");
    iterations = result.iterations;
  }
  state.counters["iterations"] = iterations;
}
BENCHMARK(feasible_fit)->Arg(3)->Arg(10)->Arg(30)->Arg(100)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace veridyn
