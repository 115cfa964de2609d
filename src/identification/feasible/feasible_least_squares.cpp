#include "veridyn/identification/feasible_least_squares.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "identification/feasible/interior_point.hpp"
#include "math/numbers.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/math/text_stream.hpp"

namespace veridyn {

namespace {

using Eigen::Matrix4d;

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr const char* kHere = "solve_feasible_least_squares: ";

void check_problem(const FeasibleProblem& problem) {
  const auto n = problem.R.cols();
  require(n > 0, kHere, "R has no columns.");
  require(problem.z.size() == problem.R.rows(), kHere, "z has ", problem.z.size(),
          " entries, R has ", problem.R.rows(), " rows.");
  require(problem.R.allFinite() && problem.z.allFinite(), kHere,
          "R or z has an entry that is not finite.");
  require(std::isfinite(problem.rho2) && problem.rho2 >= 0.0, kHere, "rho2 is ", problem.rho2,
          ", needs >= 0.");
  require(problem.G.rows() == problem.h.size(), kHere, "G has ", problem.G.rows(), " rows, h has ",
          problem.h.size(), " entries.");
  require(problem.G.rows() == 0 || problem.G.cols() == n, kHere, "G has ", problem.G.cols(),
          " columns, R has ", n, ".");
  require(problem.G.allFinite() && problem.h.allFinite(), kHere,
          "G or h has an entry that is not finite.");
  std::vector<int> columns = problem.body_columns;
  std::sort(columns.begin(), columns.end());
  for (size_t k = 0; k < columns.size(); ++k) {
    require(columns[k] >= 0 && columns[k] + 10 <= n, kHere, "a body starts at column ", columns[k],
            ", but there are ", n, " columns and a body takes ten.");
    require(k == 0 || columns[k - 1] + 10 <= columns[k], kHere, "bodies at columns ",
            columns[k == 0 ? 0 : k - 1], " and ", columns[k], " overlap.");
  }
}

void check_options(const FeasibleOptions& options, size_t bodies, Eigen::Index n) {
  require(options.gap_tolerance > 0.0, kHere, "gap_tolerance is ", options.gap_tolerance,
          ", needs > 0.");
  require(options.active_tolerance >= 0.0, kHere, "active_tolerance is ", options.active_tolerance,
          ", needs >= 0.");
  require(options.eigenvalue_margin >= 0.0 && std::isfinite(options.eigenvalue_margin), kHere,
          "eigenvalue_margin is ", options.eigenvalue_margin, ", needs >= 0.");
  require(options.max_iterations > 0, kHere, "max_iterations is ", options.max_iterations,
          ", needs > 0.");
  const EntropicPrior& entropic = options.entropic_prior;
  require(entropic.weight >= 0.0 && std::isfinite(entropic.weight), kHere,
          "the entropic prior's weight is ", entropic.weight, ", needs >= 0.");
  if (entropic.weight > 0.0) {
    require(entropic.phi.size() == bodies, kHere, "the entropic prior has ", entropic.phi.size(),
            " bodies, the problem ", bodies, ".");
    for (size_t k = 0; k < bodies; ++k) {
      if (entropic.phi[k].isZero(0.0)) continue;
      require(pseudo_inertia(entropic.phi[k]).llt().info() == Eigen::Success, kHere,
              "the entropic prior of body ", k, " is not positive definite.");
    }
  }
  const QuadraticPrior& quadratic = options.quadratic_prior;
  if (quadratic.weight.size() == 0) return;
  require(quadratic.weight.size() == n && quadratic.x.size() == n, kHere,
          "the quadratic prior has ", quadratic.weight.size(), " weights and ", quadratic.x.size(),
          " values, R has ", n, " columns.");
  require(
      quadratic.weight.allFinite() && quadratic.weight.minCoeff() >= 0.0 && quadratic.x.allFinite(),
      kHere, "the quadratic prior has a negative weight or an entry that is not finite.");
}

void add_quadratic_prior(const QuadraticPrior& prior, cone::Program& program) {
  const auto n = program.R.cols();
  const auto rows = program.R.rows();
  if (prior.weight.size() == 0) return;
  program.R.conservativeResize(rows + n, n);
  program.z.conservativeResize(rows + n);
  const VectorXd root = prior.weight.cwiseSqrt();
  program.R.bottomRows(n) = root.asDiagonal();
  program.z.tail(n) = root.cwiseProduct(prior.x);
}

void add_entropic_prior(const EntropicPrior& prior, const std::vector<int>& columns,
                        cone::Program& program) {
  if (prior.weight == 0.0) return;
  for (size_t k = 0; k < columns.size(); ++k) {
    if (prior.phi[k].isZero(0.0)) continue;
    const Eigen::LLT<Matrix4d> factor(pseudo_inertia(prior.phi[k]));
    const Matrix4d inverse = factor.solve(Matrix4d::Identity());
    const double log_det = 2.0 * factor.matrixLLT().diagonal().array().log().sum();
    cone::Block block = cone::make_block(columns[k], PhysicalCondition::kPseudoInertia);
    block.log_det_weight = prior.weight;
    block.prior = prior.phi[k];
    program.blocks.push_back(block);
    program.linear.segment<10>(columns[k]) += prior.weight * pseudo_inertia_adjoint(inverse);
    program.constant += prior.weight * (log_det - 4.0);
  }
}

// The log-det term of an entropic prior keeps J > 0, so that the blocks of the condition are redundant.
bool needs_condition_blocks(const FeasibleOptions& options) {
  if (options.condition == PhysicalCondition::kNone) return false;
  return options.entropic_prior.weight == 0.0 || options.eigenvalue_margin > 0.0;
}

// Blocks: those of the condition, body by body, then those of the entropic prior.
cone::Program make_program(const FeasibleProblem& problem, const FeasibleOptions& options) {
  cone::Program program;
  program.R = problem.R;
  program.z = problem.z;
  program.linear = VectorXd::Zero(problem.R.cols());
  program.constant = problem.rho2;
  program.rows = cone::sparse_rows(problem.G, problem.h);
  if (needs_condition_blocks(options)) {
    for (const int column : problem.body_columns) {
      program.blocks.push_back(cone::make_block(column, options.condition));
      program.blocks.back().margin = options.eigenvalue_margin;
    }
  }
  add_entropic_prior(options.entropic_prior, problem.body_columns, program);
  add_quadratic_prior(options.quadratic_prior, program);
  program.box = cone::implied_box(program.rows, program.blocks, program.variables());
  const VectorXd norms = program.R.colwise().norm().transpose();
  program.box.trusted = VectorXd::Zero(norms.size());
  for (int j = 0; j < norms.size(); ++j) {
    if (norms(j) > 1e-13 * norms.maxCoeff()) program.box.trusted(j) = program.z.norm() / norms(j);
  }
  // The lightest possible body has moments of inertia of twice the margin: the box admits it, however small the torques are.
  for (const cone::Block& block : program.blocks) {
    auto trusted = program.box.trusted.segment<10>(block.column);
    trusted = (trusted.array() > 0.0).select(trusted.cwiseMax(4.0 * block.margin), trusted);
  }
  return program;
}

// See FeasibleOptions::gap_tolerance.
double cost_floor(const FeasibleProblem& problem, const FeasibleOptions& options,
                  const cone::Program& program) {
  double floor = 1e-4 * (problem.z.squaredNorm() + problem.rho2);
  if (floor == 0.0) floor = 1e-10 * problem.R.squaredNorm();
  double prior_terms = 0.0;
  for (const cone::Block& block : program.blocks) {
    for (int j = 0; j < 10 && block.log_det_weight > 0.0; ++j) {
      const int column = block.column + j;
      prior_terms += std::abs(program.linear(column)) *
                     (4.0 * std::abs(block.prior(j)) + program.box.reach(column));
    }
  }
  floor = std::max(floor, 64.0 * kEpsilon * prior_terms / options.gap_tolerance);
  return floor > 0.0 ? floor : 1.0;
}

bool is_strictly_feasible(const cone::Program& program, const VectorXd& x) {
  if (!x.allFinite()) return false;
  if (program.rows.size() > 0 && !(program.rows.slack(x).minCoeff() > 0.0)) return false;
  return std::all_of(program.blocks.begin(), program.blocks.end(), [&](const cone::Block& block) {
    return smallest_eigenvalue(block.slack(x)) > 0.0;
  });
}

// Rounding can leave x a few units in the last place outside; a tiny step towards an interior point
// corrects this.
void pull_inside(const cone::Program& program, const VectorXd& interior, VectorXd& x) {
  if (interior.size() == 0 || is_strictly_feasible(program, x)) return;
  for (double part = 1e-14; part < 1.0; part *= 4.0) {
    const VectorXd moved = x + part * (interior - x);
    if (!is_strictly_feasible(program, moved)) continue;
    x = moved;
    return;
  }
}

void list_active_constraints(const FeasibleProblem& problem, const FeasibleOptions& options,
                             const cone::Program& program, FeasibleResult& result) {
  const VectorXd slack = program.rows.slack(result.x);
  for (int i = 0; i < slack.size(); ++i) {
    double size = std::abs(problem.h(i));
    for (int a = program.rows.start[i]; a < program.rows.start[i + 1]; ++a) {
      const int j = program.rows.column[a];
      size +=
          std::abs(program.rows.value[a]) * std::max(std::abs(result.x(j)), program.box.reach(j));
    }
    if (slack(i) > options.active_tolerance * size) continue;
    result.active_rows.push_back({i, slack(i), result.row_multipliers(i)});
  }
  if (!needs_condition_blocks(options)) return;
  for (size_t k = 0; k < problem.body_columns.size(); ++k) {
    const Matrix4d S = program.blocks[k].slack(result.x);
    const double scaled = smallest_scaled_eigenvalue(S);
    if (scaled > options.active_tolerance) continue;
    const Eigen::SelfAdjointEigenSolver<Matrix4d> eigen(program.blocks[k].apply(result.x),
                                                        Eigen::EigenvaluesOnly);
    result.active_bodies.push_back(
        {static_cast<int>(k), scaled, eigen.eigenvalues(), result.body_multipliers[k]});
  }
}

FeasibleResult make_result(const FeasibleProblem& problem, const FeasibleOptions& options,
                           const cone::Program& program, cone::Solution& solution,
                           const cone::Stop& stop) {
  FeasibleResult result;
  pull_inside(program, solution.interior, solution.point.x);
  const VectorXd& x = solution.point.x;
  result.x = x;
  result.status = solution.status;
  result.iterations = solution.iterations;
  result.feasible = is_strictly_feasible(program, x);
  result.objective = (problem.R * x - problem.z).squaredNorm() + problem.rho2;
  result.cost = cone::cost(program, x);
  result.row_multipliers = solution.point.lambda;
  result.body_multipliers.assign(problem.body_columns.size(), Matrix4d::Zero());
  if (needs_condition_blocks(options)) {
    std::copy_n(solution.point.Z.begin(), problem.body_columns.size(),
                result.body_multipliers.begin());
  }
  const double scale = std::max(result.cost, stop.cost_floor);
  if (result.status == FeasibleStatus::kInfeasible) {
    result.lower_bound = result.duality_gap = kInfinity;
    result.unbounded_columns = solution.unbounded_columns;
  } else {
    const cone::Bound bound = cone::duality_gap(program, solution.point, program.R * x - program.z);
    result.lower_bound = result.cost - bound.gap;
    result.duality_gap = bound.gap / scale;
    result.unbounded_columns = bound.unbounded_columns;
    const bool optimal = result.feasible && bound.gap <= options.gap_tolerance * scale;
    if (optimal)
      result.status = FeasibleStatus::kOptimal;
    else if (result.status == FeasibleStatus::kOptimal)
      result.status = FeasibleStatus::kNotConverged;
    list_active_constraints(problem, options, program, result);
  }
  result.certificate =
      result.unbounded_columns.empty() ? Certificate::kRigorous : Certificate::kNoBox;
  return result;
}

const char* status_text(FeasibleStatus status) {
  static constexpr const char* kNames[] = {
      "optimal", "infeasible: no parameters satisfy all constraints",
      "no interior: constraints leave no room between them", "not converged"};
  return kNames[static_cast<int>(status)];
}

}  // namespace

FeasibleResult solve_feasible_least_squares(const FeasibleProblem& problem,
                                            const FeasibleOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  check_problem(problem);
  check_options(options, problem.body_columns.size(), problem.R.cols());
  const cone::Program program = make_program(problem, options);
  cone::Stop stop;
  stop.gap_tolerance = options.gap_tolerance;
  stop.cost_floor = cost_floor(problem, options, program);
  stop.max_iterations = options.max_iterations;
  cone::Solution solution = cone::solve(program, stop);
  FeasibleResult result = make_result(problem, options, program, solution, stop);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

std::string FeasibleResult::report() const {
  TextStream out;
  out.precision(12);
  out << "feasible least squares: " << status_text(status) << " after " << iterations
      << " iterations, " << text(1e3 * seconds) << " ms\n";
  out << "objective " << objective;
  if (cost != objective) out << " (with priors " << cost << ")";
  out << ", lower bound " << lower_bound << ", relative gap " << text(duality_gap)
      << (certificate == Certificate::kRigorous ? " (rigorous)"
                                                : " (some parameters have no bounds)")
      << "\n";
  out << (feasible ? "strictly feasible" : "NOT strictly feasible") << "; " << active_bodies.size()
      << " bodies at the edge of physics, " << active_rows.size() << " bounds active\n";
  for (const ActiveBody& active : active_bodies) {
    out << "  body " << active.body << ": smallest eigenvalue " << text(active.eigenvalues(0))
        << "\n";
  }
  for (const ActiveRow& active : active_rows) {
    out << "  bound " << active.row << ": multiplier " << text(active.multiplier) << "\n";
  }
  return out.str();
}

}  // namespace veridyn
