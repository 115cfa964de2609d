#include "identification/drive_gains/gain_problem.hpp"

#include <algorithm>
#include <cmath>

#include "identification/identification_numbers.hpp"
#include "math/dense.hpp"

namespace veridyn {
namespace {

constexpr double kTiny = 1e-300;

Eigen::Index total_rows(const std::vector<GainEquation>& equations) {
  Eigen::Index rows = 0;
  for (const GainEquation& e : equations) rows += e.z.size();
  return rows;
}

// Scales columns to norm one, for pivoting and damping; zero columns are kept.
VectorXd scale_columns(MatrixXd& A) {
  VectorXd scale(A.cols());
  for (Eigen::Index c = 0; c < A.cols(); ++c) {
    const double norm = A.col(c).norm();
    scale[c] = norm > 0.0 ? 1.0 / norm : 0.0;
    A.col(c) *= scale[c];
  }
  return scale;
}

VectorXd current_of(const GainEquation& e, const GainSolution& at, Eigen::Index joint) {
  return at.ratio[joint] * (e.U * at.y + at.scale * e.k);
}

double cost_at(const std::vector<GainEquation>& equations, const VectorRef& sigma,
               const GainSolution& at) {
  const VectorXd residual = residual_current(equations, at);
  double cost = 0.0;
  for (Eigen::Index j = 0; j < residual.size(); ++j)
    cost += equations[j].rows * std::pow(residual[j] / sigma[j], 2);
  return cost;
}

// Joints without a defined gain, for which least squares give zero gain and zero torque.
std::vector<char> without_scale(const VectorXd& gain) {
  const double least = std::max(identifying::kNoScale * gain.cwiseAbs().maxCoeff(), kTiny);
  std::vector<char> out;
  for (const double k : gain) out.push_back(static_cast<char>(std::abs(k) <= least));
  return out;
}

// Derivatives of the weighted residuals with respect to y, the scale and the ratios (zero for the reference
// joint's), followed by `spare` rows of zeros.
MatrixXd jacobian(const std::vector<GainEquation>& equations, const VectorRef& sigma,
                  const GainSolution& at, Eigen::Index spare) {
  const Eigen::Index unknowns = at.y.size();
  const Eigen::Index n = at.ratio.size();
  MatrixXd A = MatrixXd::Zero(total_rows(equations) + spare, unknowns + 1 + n);
  Eigen::Index row = 0;
  for (Eigen::Index j = 0; j < n; ++j) {
    const GainEquation& e = equations[j];
    const Eigen::Index count = e.z.size();
    A.block(row, 0, count, unknowns) = at.ratio[j] / sigma[j] * e.U;
    A.block(row, unknowns, count, 1) = at.ratio[j] / sigma[j] * e.k;
    if (j != at.reference)
      A.block(row, unknowns + 1 + j, count, 1) = (e.U * at.y + at.scale * e.k) / sigma[j];
    row += count;
  }
  return A;
}

// A damped Gauss-Newton step.
VectorXd step_at(const std::vector<GainEquation>& equations, const VectorRef& sigma,
                 const GainSolution& at, double damping) {
  const Eigen::Index columns = at.y.size() + 1 + at.ratio.size();
  MatrixXd A = jacobian(equations, sigma, at, columns);
  VectorXd b = VectorXd::Zero(A.rows());
  Eigen::Index row = 0;
  for (Eigen::Index j = 0; j < at.ratio.size(); ++j) {
    const GainEquation& e = equations[j];
    b.segment(row, e.z.size()) = (e.z - current_of(e, at, j)) / sigma[j];
    row += e.z.size();
  }
  const VectorXd scale = scale_columns(A);
  A.bottomRows(columns).diagonal().setConstant(std::sqrt(damping));
  return scale.cwiseProduct(least_squares_solution(A, b));
}

// Solves U x + k = K z for x and K with weights as for the currents, then K for that x. Given gains are one.
VectorXd linear_solution(const std::vector<GainEquation>& equations, const VectorXd& weights,
                         const std::vector<char>& given) {
  const Eigen::Index unknowns = equations.front().U.cols();
  const Eigen::Index n = weights.size();
  MatrixXd A = MatrixXd::Zero(total_rows(equations), unknowns + n);
  VectorXd b(A.rows());
  Eigen::Index row = 0;
  for (Eigen::Index j = 0; j < n; ++j) {
    const GainEquation& e = equations[j];
    const Eigen::Index count = e.z.size();
    A.block(row, 0, count, unknowns) = weights[j] * e.U;
    const bool fixed = given[j] != 0;
    if (!fixed) A.block(row, unknowns + j, count, 1) = -weights[j] * e.z;
    b.segment(row, count) = weights[j] * ((fixed ? 1.0 : 0.0) * e.z - e.k);
    row += count;
  }
  const VectorXd scale = scale_columns(A);
  VectorXd out = scale.cwiseProduct(least_squares_solution(A, b));
  for (Eigen::Index j = 0; j < n; ++j) {
    if (given[j] != 0) out[unknowns + j] = 1.0;
  }
  return out;
}

}  // namespace

VectorXd independent_shares(const std::vector<GainEquation>& equations, const VectorRef& sigma,
                            const GainSolution& at) {
  MatrixXd A = jacobian(equations, sigma, at, 0);
  scale_columns(A);
  const Eigen::Index unknowns = at.y.size();
  VectorXd out(at.ratio.size());
  for (Eigen::Index j = 0; j < out.size(); ++j) {
    const Eigen::Index column = j == at.reference ? unknowns : unknowns + 1 + j;
    const VectorXd own = A.col(column);
    A.col(column).setZero();
    out[j] = (own - A * least_norm(A, own)).norm();
    A.col(column) = own;
  }
  return out;
}

VectorXd residual_current(const std::vector<GainEquation>& equations, const GainSolution& at) {
  VectorXd out(equations.size());
  for (Eigen::Index j = 0; j < out.size(); ++j) {
    const GainEquation& e = equations[j];
    const double sum = (current_of(e, at, j) - e.z).squaredNorm() + e.rho2;
    out[j] = std::sqrt(sum / std::max(e.rows, 1.0));
  }
  return out;
}

GainSolution start_gains(const std::vector<GainEquation>& equations, const VectorRef& sigma) {
  const Eigen::Index unknowns = equations.front().U.cols();
  const auto n = static_cast<Eigen::Index>(equations.size());
  const VectorXd currents = sigma.cwiseInverse();
  std::vector<char> given(n, 0);
  given = without_scale(linear_solution(equations, currents, given).tail(n));
  VectorXd solution = linear_solution(equations, currents, given);
  // Torque errors are K times current errors: weighted with the gains of the previous round.
  for (int round = 0; round < 2; ++round) {
    const VectorXd weights = currents.cwiseQuotient(solution.tail(n).cwiseAbs().cwiseMax(kTiny));
    solution = linear_solution(equations, weights, given);
  }
  const VectorXd x = solution.head(unknowns);
  const VectorXd gain = solution.tail(n);
  GainSolution out;
  double best = -1.0;
  for (Eigen::Index j = 0; j < n; ++j) {
    const double felt = equations[j].k.norm() / (std::abs(gain[j]) * sigma[j]);
    if (felt <= best) continue;
    best = felt;
    out.reference = static_cast<int>(j);
  }
  out.scale = 1.0 / gain[out.reference];
  out.ratio = gain[out.reference] * gain.cwiseInverse();
  out.y = out.scale * x;
  out.cost = cost_at(equations, sigma, out);
  return out;
}

GainSolution solve_gains(const std::vector<GainEquation>& equations, const VectorRef& sigma,
                         const GainSolution& start) {
  GainSolution now = start;
  now.cost = cost_at(equations, sigma, now);
  const Eigen::Index unknowns = now.y.size();
  double damping = identifying::kFirstDamping;
  for (int k = 0; k < identifying::kIterations && damping < identifying::kMostDamping; ++k) {
    const VectorXd step = step_at(equations, sigma, now, damping);
    GainSolution next = now;
    next.y += step.head(unknowns);
    next.scale += step[unknowns];
    next.ratio += step.tail(now.ratio.size());
    next.cost = cost_at(equations, sigma, next);
    if (!(next.cost <= now.cost)) {
      damping *= identifying::kDampingUp;
      continue;
    }
    const bool done = now.cost - next.cost <= identifying::kConverged * now.cost;
    now = next;
    now.converged = done;
    if (done) break;
    damping = std::max(identifying::kLeastDamping, damping / identifying::kDampingUp);
  }
  return now;
}

}  // namespace veridyn
