#include "identification/feasible/interior_point.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

namespace veridyn::cone {

namespace {

using Eigen::Matrix4d;

constexpr double kCloseEnough =
    0.5;  // relative distance, at which a slack is replaced by its exact value at x
constexpr double kSmallAbsorption =
    0.1;  // largest relative change of a multiplier to match the gradient
constexpr double kBoundary = 0.99;  // share of the step to the boundary of the cones
// Where a factorization costs much more than a solution (kManyVariables), the corrector is repeated with its
// own second-order term as long as this lengthens a short step. Iterations with 0, 1 and 3 repeats: 16, 13,
// 13 at 30 bodies, 17, 15, 13 at 100 (`veridyn-benchmark`, feasible_fit).
constexpr int kMoreCorrectors = 3;
constexpr int kManyVariables = 200;
constexpr double kLongStep = 0.95;
constexpr double kWorthwhile = 1.01;  // ratio of the steps, from which a repeat was worthwhile
constexpr double kFirstRegularisation = 1e-14;
constexpr double kLastRegularisation = 1e-5;
constexpr int kPatience = 10;  // iterations without a smaller gap
// With an entropic prior a body far from its prior needs many short steps, during which the gap does not
// measure progress.
constexpr int kPatienceWithPrior = 50;

class InteriorPoint {
 public:
  /// @param balanced  complementarity does not fall below the part of the gap that the dual residual is
  /// expected to leave after a step.
  InteriorPoint(const Program& program, const Stop& stop, double first_gap, bool balanced);
  Solution run();

 private:
  void update_residuals();
  void update_row_residuals();
  void absorb_dual_residual(size_t k);
  bool factor();
  void set_up_schur_complement();
  void advance_direction();
  void find_direction(double target, bool second_order);
  double complementarity(double step) const;
  double dual_gap() const;
  double longest_common_step(double enough) const;
  double correct_direction(double target);
  void take_step();
  bool feasible() const;
  bool finish(Solution& solution);

  const Program& program_;
  const Stop& stop_;
  const bool balanced_;
  const int n_;
  const bool R_is_triangle_;
  int patience_ = kPatience;
  int plain_degree_ = 0;  // total degree of the cones without a log-det term
  MatrixXd hessian_;      // 2*R'*R, lower triangle
  MatrixXd factor_;       // L of the Schur complement L*L', lower triangle
  Point point_;
  VectorXd slack_, row_residual_;  // row_residual = h - G*x - slack
  std::vector<char> row_follows_x_;
  std::vector<ScaledBlock> blocks_;
  VectorXd residual_, dual_residual_;
  VectorXd dx_, dslack_, dlambda_;
  double best_gap_ = std::numeric_limits<double>::infinity();
  int best_iteration_ = 0;
};

// 2*R'*R, lower triangle; a third of the operations suffices where R is a triangle.
MatrixXd hessian_of(const MatrixXd& R, bool is_triangle) {
  constexpr Eigen::Index kPanel = 64;
  const Eigen::Index n = R.cols();
  MatrixXd out = MatrixXd::Zero(n, n);
  if (!is_triangle) {
    out.selfadjointView<Eigen::Lower>().rankUpdate(R.transpose(), 2.0);
    return out;
  }
  for (Eigen::Index j = 0; j < n; j += kPanel) {
    const Eigen::Index width = std::min(kPanel, n - j);
    const auto rows = R.topRows(j + width);
    out.block(j, j, n - j, width).noalias() =
        2.0 * rows.rightCols(n - j).transpose() * rows.middleCols(j, width);
  }
  return out;
}

InteriorPoint::InteriorPoint(const Program& program, const Stop& stop, double first_gap,
                             bool balanced)
    : program_(program),
      stop_(stop),
      balanced_(balanced),
      n_(program.variables()),
      R_is_triangle_(program.R.rows() == n_ && program.R.isUpperTriangular(0.0)),
      hessian_(hessian_of(program.R, R_is_triangle_)) {
  Start start = starting_point(program, hessian_, stop.cost_floor, first_gap);
  point_.x = std::move(start.x);
  point_.lambda = std::move(start.lambda);
  slack_ = std::move(start.slack);
  blocks_ = std::move(start.blocks);
  row_follows_x_.assign(slack_.size(), 0);
  plain_degree_ = program.rows.size();
  for (const Block& block : program.blocks) {
    plain_degree_ += block.log_det_weight == 0.0 ? 4 : 0;
    if (block.log_det_weight > 0.0) patience_ = kPatienceWithPrior;
  }
  point_.Z.resize(blocks_.size());
  update_residuals();
}

void InteriorPoint::update_row_residuals() {
  row_residual_ = program_.rows.slack(point_.x) - slack_;
  for (int i = 0; i < slack_.size(); ++i) {
    if (!row_follows_x_[i] && std::abs(row_residual_(i)) > kCloseEnough * slack_(i)) continue;
    row_follows_x_[i] = 1;
    slack_(i) += row_residual_(i);
    row_residual_(i) = 0.0;
  }
}

void InteriorPoint::update_residuals() {
  if (R_is_triangle_) {
    const auto R = program_.R.triangularView<Eigen::Upper>();
    residual_.noalias() = R * point_.x;
    residual_ -= program_.z;
    dual_residual_.noalias() = R.transpose() * residual_;
  } else {
    residual_ = program_.R * point_.x - program_.z;
    dual_residual_.noalias() = program_.R.transpose() * residual_;
  }
  dual_residual_ = 2.0 * dual_residual_ + program_.linear;
  program_.rows.add_transposed(point_.lambda, dual_residual_);
  update_row_residuals();
  for (size_t k = 0; k < blocks_.size(); ++k) {
    const Block& block = program_.blocks[k];
    ScaledBlock& state = blocks_[k];
    dual_residual_.segment<10>(block.column) -= block.adjoint(state.Z);
    const Matrix4d slack = block.slack(point_.x);
    state.residual = slack - state.S;
    if (!state.follows_x) state.follows_x = relative_norm(state.S, state.residual) <= kCloseEnough;
    if (state.follows_x) {
      state.S = slack;
      state.residual.setZero();
    }
  }
  for (size_t k = 0; k < blocks_.size(); ++k) absorb_dual_residual(k);
}

// The adjoint of the pseudo-inertia is invertible, so that Z can absorb the dual residual of its
// body: rounding in the Newton system then does not limit the certified gap.
void InteriorPoint::absorb_dual_residual(size_t k) {
  const Block& block = program_.blocks[k];
  if (!block.is_pseudo_inertia) return;
  const Matrix4d change = pseudo_inertia_from_adjoint(dual_residual_.segment<10>(block.column));
  if (relative_norm(blocks_[k].Z, change) > kSmallAbsorption) return;
  dual_residual_.segment<10>(block.column) += block.adjoint(blocks_[k].Z);
  blocks_[k].Z += change;
  dual_residual_.segment<10>(block.column) -= block.adjoint(blocks_[k].Z);
}

bool InteriorPoint::factor() {
  for (ScaledBlock& block : blocks_) {
    if (!block.scale()) return false;
  }
  for (double relative = kFirstRegularisation; relative < kLastRegularisation; relative *= 100.0) {
    set_up_schur_complement();
    for (int j = 0; j < n_; ++j) {
      double& diagonal = factor_(j, j);
      diagonal = diagonal > 0.0 ? diagonal * (1.0 + relative) : 1.0;
    }
    // The factorization is in place; Eigen::LLT would copy the matrix and compute its norm.
    if (Eigen::internal::llt_inplace<double, Eigen::Lower>::blocked(factor_) < 0) return true;
  }
  return false;
}

void InteriorPoint::set_up_schur_complement() {
  MatrixXd& M = factor_;
  M.resize(n_, n_);
  for (int j = 0; j < n_; ++j) M.col(j).tail(n_ - j) = hessian_.col(j).tail(n_ - j);
  const SparseRows& rows = program_.rows;
  for (int i = 0; i < rows.size(); ++i) {
    const double weight = point_.lambda(i) / slack_(i);
    for (int a = rows.start[i]; a < rows.start[i + 1]; ++a) {
      for (int b = rows.start[i]; b <= a; ++b) {
        M(rows.column[a], rows.column[b]) += weight * rows.value[a] * rows.value[b];
      }
    }
  }
  for (size_t k = 0; k < blocks_.size(); ++k) {
    const int c = program_.blocks[k].column;
    M.block<10, 10>(c, c) += block_hessian(program_.blocks[k].map, blocks_[k].P);
  }
}

// Solves once for dx from the residual of the whole dual equation, 2*R'*R*dx + G'*dlambda -
// adjoint(dZ) + dual_residual = 0, at the present directions. A second call is a step of iterative
// refinement: near the boundary the Schur complement has entries of 1/slack^2.
void InteriorPoint::advance_direction() {
  VectorXd rhs = -dual_residual_;
  if (!dx_.isZero(0.0)) rhs.noalias() -= hessian_.selfadjointView<Eigen::Lower>() * dx_;
  program_.rows.add_transposed(-dlambda_, rhs);
  for (size_t k = 0; k < blocks_.size(); ++k) {
    const Block& block = program_.blocks[k];
    rhs.segment<10>(block.column) += block.adjoint(blocks_[k].dZ);
  }
  factor_.triangularView<Eigen::Lower>().solveInPlace(rhs);
  factor_.triangularView<Eigen::Lower>().transpose().solveInPlace(rhs);
  const VectorXd& change = rhs;
  dx_ += change;
  for (int i = 0; i < slack_.size(); ++i) {
    const double moved = program_.rows.dot(i, change);
    dslack_(i) -= moved;
    dlambda_(i) += point_.lambda(i) / slack_(i) * moved;
  }
  for (size_t k = 0; k < blocks_.size(); ++k) {
    blocks_[k].advance_direction(program_.blocks[k].apply(change));
  }
}

void InteriorPoint::find_direction(double target, bool second_order) {
  VectorXd product = VectorXd::Constant(slack_.size(), target);
  if (second_order) product -= dslack_.cwiseProduct(dlambda_);
  dx_.setZero(n_);
  dslack_ = row_residual_;
  dlambda_ = (product - point_.lambda.cwiseProduct(slack_ + row_residual_)).cwiseQuotient(slack_);
  for (size_t k = 0; k < blocks_.size(); ++k) {
    blocks_[k].begin_direction(std::max(target, program_.blocks[k].log_det_weight), second_order);
  }
  advance_direction();
  if (second_order) advance_direction();
}

// Mean of lambda*slack and of the eigenvalues of S*Z after a step; log-det blocks have their own
// target.
double InteriorPoint::complementarity(double step) const {
  if (plain_degree_ == 0) return 0.0;
  double sum = 0.0;
  if (step == 0.0)
    sum = slack_.dot(point_.lambda);
  else
    sum = (slack_ + step * dslack_).dot(point_.lambda + step * dlambda_);
  for (size_t k = 0; k < blocks_.size(); ++k) {
    if (program_.blocks[k].log_det_weight != 0.0) continue;
    const ScaledBlock& state = blocks_[k];
    sum += (state.S + step * state.dS).cwiseProduct(state.Z + step * state.dZ).sum();
  }
  return std::max(sum, 0.0) / plain_degree_;
}

// Part of the duality gap that the dual residual causes.
double InteriorPoint::dual_gap() const {
  std::vector<int> unbounded;
  return gain_over_box(program_, point_.x, dual_residual_, VectorXd::Zero(n_), unbounded);
}

// Largest step to the boundary of the cones, or `enough` if that is smaller.
double InteriorPoint::longest_common_step(double enough) const {
  double step = std::min({enough, longest_step(slack_, dslack_),
                          longest_step(point_.lambda, dlambda_)});
  for (const ScaledBlock& state : blocks_) {
    for (const Matrix4d* direction : {&state.scaled_dS, &state.scaled_dZ}) {
      if (!stays_positive(state.d, *direction, step))
        step = std::min(step, longest_step(state.d, *direction));
    }
  }
  return step;
}

// Corrects the predictor. @returns the step to take.
double InteriorPoint::correct_direction(double target) {
  find_direction(target, true);
  double step = kBoundary * longest_common_step(1.0 / kBoundary);
  const int repeats = n_ < kManyVariables ? 0 : kMoreCorrectors;
  for (int more = 0; more < repeats && step < kLongStep; ++more) {
    VectorXd dx = dx_, dslack = dslack_, dlambda = dlambda_;
    std::vector<ScaledBlock> blocks = blocks_;
    find_direction(target, true);
    const double longer = kBoundary * longest_common_step(1.0 / kBoundary);
    if (longer > kWorthwhile * step) {
      step = longer;
      continue;
    }
    dx_.swap(dx);
    dslack_.swap(dslack);
    dlambda_.swap(dlambda);
    blocks_.swap(blocks);
    break;
  }
  return step;
}

void InteriorPoint::take_step() {
  const double mu = complementarity(0.0);
  find_direction(0.0, false);
  double target = 0.0;
  if (mu > 0.0) {
    const double affine = longest_common_step(1.0);
    const double ratio = std::min(1.0, complementarity(affine) / mu);
    target = ratio * ratio * ratio * mu;  // Mehrotra's rule
    if (balanced_) target = std::max(target, std::min(mu, (1.0 - affine) * dual_gap() / plain_degree_));
  }
  const double step = correct_direction(target);
  point_.x += step * dx_;
  point_.lambda += step * dlambda_;
  slack_ += step * dslack_;
  for (ScaledBlock& state : blocks_) {
    state.S += step * state.dS;
    state.Z += step * state.dZ;
  }
}

bool InteriorPoint::feasible() const {
  const auto is_true = [](char closed) { return closed != 0; };
  return std::all_of(row_follows_x_.begin(), row_follows_x_.end(), is_true) &&
         std::all_of(blocks_.begin(), blocks_.end(),
                     [](const ScaledBlock& s) { return s.follows_x; });
}

// Keeps the best feasible point. @returns true if the iteration has converged.
bool InteriorPoint::finish(Solution& solution) {
  if (solution.interior.size() == 0) solution.interior = point_.x;
  const double tolerance =
      stop_.gap_tolerance * std::max(cost(program_, point_.x, residual_), stop_.cost_floor);
  if (plain_degree_ * complementarity(0.0) > tolerance) {  // part of the gap, which is expensive
    solution.point = point_;
    best_iteration_ = solution.iterations;
    return false;
  }
  const double gap = duality_gap(program_, point_, residual_).gap;
  if (gap < best_gap_) {
    if (gap < 0.9 * best_gap_) best_iteration_ = solution.iterations;
    best_gap_ = gap;
    solution.point = point_;
  }
  if (gap <= tolerance) solution.status = FeasibleStatus::kOptimal;
  return gap <= tolerance || solution.iterations - best_iteration_ >= patience_;
}

Solution InteriorPoint::run() {
  Solution solution;
  for (solution.iterations = 0; solution.iterations <= stop_.max_iterations;
       ++solution.iterations) {
    if (!point_.x.allFinite()) break;
    for (size_t k = 0; k < blocks_.size(); ++k) point_.Z[k] = blocks_[k].Z;
    if (feasible()) {
      if (finish(solution)) return solution;
    } else if (proves_infeasible(program_, point_, solution.unbounded_columns)) {
      solution.status = FeasibleStatus::kInfeasible;
      solution.point = point_;
      return solution;
    }
    if (solution.iterations == stop_.max_iterations || !factor()) break;
    take_step();
    update_residuals();
  }
  if (solution.point.x.size() == 0) {
    solution.point = point_;
    if (met_to_rounding(program_, point_.x)) solution.status = FeasibleStatus::kNoInterior;
  }
  return solution;
}

}  // namespace

Solution solve(const Program& program, const Stop& stop) {
  Solution solution;
  int iterations = 0;
  double first_gap = 0.0;
  for (const double gap : {1e-3, 1e1, 1e5}) {
    first_gap = gap;
    solution = InteriorPoint(program, stop, first_gap, false).run();
    iterations += solution.iterations;
    const bool prior = std::any_of(program.blocks.begin(), program.blocks.end(),
                                   [](const Block& b) { return b.log_det_weight > 0.0; });
    const bool over = solution.status == FeasibleStatus::kOptimal || !prior;
    if ((solution.interior.size() > 0 && over) || solution.status == FeasibleStatus::kInfeasible) break;
  }
  // Iterates that reach the boundary with a dual residual cannot continue: steps that would reduce it leave
  // the cones. Of 300 random problems with 3 bodies 5 ended in this state at gaps of 1e-9 to 4e-9; with the
  // balanced method all converge, in 6 to 34 % more iterations.
  if (solution.status == FeasibleStatus::kNotConverged) {
    const Solution again = InteriorPoint(program, stop, first_gap, true).run();
    iterations += again.iterations;
    if (again.status == FeasibleStatus::kOptimal) solution = again;
  }
  solution.iterations = iterations;
  return solution;
}

}  // namespace veridyn::cone
