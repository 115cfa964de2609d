#include "excitation/search/search_program.hpp"
#include "math/numbers.hpp"

#include <algorithm>
#include <cmath>

namespace veridyn {
namespace {

constexpr double kHeld = 2e-6;  // violation that counts as none, as a share of a limit's scale
// Weight of a regularisation that keeps the motion bounded.
constexpr double kPullBack = 1e-4;

}  // namespace

GridConstraints::GridConstraints(const MotionSpace& space, const LimitSignals& signals,
                                 int instants)
    : space_(space),
      signals_(signals),
      basis_(space.basis(period_instants(space.frequency(), instants))) {
  for (int k = 0; k < signals.count(); ++k) {
    if (std::isfinite(signals[k].lower) || std::isfinite(signals[k].upper)) kept_.push_back(k);
  }
  const int n = space.joints();
  const int p = space.per_joint();
  std::vector<double> constant;
  int row = 0;
  for (const int k : kept_) {
    if (k < 3 * n) joint_rows_ = row + instants;
    for (int t = 0; t < instants; ++t, ++row) {
      if (k >= 3 * n) {
        for (int c = 0; c < space.size(); ++c) pattern_.emplace_back(row, c);
        continue;
      }
      const MatrixXd& B = k < n ? basis_.q : k < 2 * n ? basis_.dq : basis_.ddq;
      const double unit = space.size_of(k % n) / signals[k].scale;
      for (int c = k < n ? 0 : 1; c < p; ++c) {
        pattern_.emplace_back(row, (k % n) * p + c);
        constant.push_back(unit * B(t, c));
      }
    }
  }
  constant_ =
      Eigen::Map<const VectorXd>(constant.data(), static_cast<Eigen::Index>(constant.size()));
  VectorXd low(signals.count());
  VectorXd high(signals.count());
  for (int k = 0; k < signals.count(); ++k) {
    low[k] = signals[k].lower;
    high[k] = signals[k].upper;
  }
  set_bounds(low, high);
}

void GridConstraints::set_bounds(const VectorXd& lower, const VectorXd& upper) {
  const Eigen::Index instants = basis_.time.size();
  lower_.resize(instants * static_cast<Eigen::Index>(kept_.size()));
  upper_.resize(lower_.size());
  Eigen::Index row = 0;
  for (const int k : kept_) {
    lower_.segment(row, instants).setConstant(lower[k] / signals_[k].scale);
    upper_.segment(row, instants).setConstant(upper[k] / signals_[k].scale);
    row += instants;
  }
}

void GridConstraints::set_spans(std::vector<Span> spans) {
  const Eigen::Index rows = lower_.size();
  const auto more = static_cast<Eigen::Index>(spans.size());
  lower_.conservativeResize(rows + more);
  upper_.conservativeResize(rows + more);
  upper_.tail(more).setConstant(kInfinity);
  const int p = space_.per_joint();
  for (Eigen::Index s = 0; s < more; ++s) {
    lower_[rows + s] = spans[s].least / signals_[spans[s].joint].scale;
    for (int c = 1; c < p; ++c) pattern_.emplace_back(static_cast<int>(rows + s), spans[s].joint * p + c);
  }
  spans_ = std::move(spans);
}

VectorXd GridConstraints::values(const VectorXd& x) const {
  const MotionSamples m = space_.samples(basis_, x);
  const Eigen::Index instants = basis_.time.size();
  const int n = space_.joints();
  MatrixXd other;
  if (kept_.back() >= 3 * n) other = signals_.values(m);
  VectorXd out(lower_.size());
  Eigen::Index row = 0;
  for (const int k : kept_) {
    const MatrixXd& part = k < n ? m.q : k < 2 * n ? m.dq : k < 3 * n ? m.ddq : other;
    const Eigen::Index column = k < 3 * n ? k % n : k - 3 * n;
    out.segment(row, instants) = part.col(column) / signals_[k].scale;
    row += instants;
  }
  for (const Span& s : spans_) out[row++] = (m.q(s.high, s.joint) - m.q(s.low, s.joint)) / signals_[s.joint].scale;
  return out;
}

VectorXd GridConstraints::jacobian(const VectorXd& x) const {
  const int n = space_.joints();
  const int p = space_.per_joint();
  VectorXd out(pattern_.size());
  out.head(constant_.size()) = constant_;
  Eigen::Index next = out.size() - static_cast<Eigen::Index>(spans_.size()) * (p - 1);
  const bool joints_alone = constant_.size() == next;
  for (const Span& s : spans_) {
    out.segment(next, p - 1) = space_.size_of(s.joint) / signals_[s.joint].scale *
                               (basis_.q.row(s.high) - basis_.q.row(s.low)).tail(p - 1).transpose();
    next += p - 1;
  }
  if (joints_alone) return out;
  const std::vector<MatrixXd> slopes = signals_.derivatives(space_.samples(basis_, x));
  next = constant_.size();
  for (const int k : kept_) {
    if (k < 3 * n) continue;
    const MatrixXd& by_state = slopes[k - 3 * n];
    for (Eigen::Index t = 0; t < basis_.time.size(); ++t) {
      for (int i = 0; i < n; ++i) {
        const double unit = space_.size_of(i) / signals_[k].scale;
        out.segment(next, p) =
            unit * (by_state(t, i) * basis_.q.row(t) + by_state(t, n + i) * basis_.dq.row(t) +
                    by_state(t, 2 * n + i) * basis_.ddq.row(t))
                       .transpose();
        next += p;
      }
    }
  }
  return out;
}

GridConstraints::Violation GridConstraints::violation(const VectorXd& values) const {
  Violation worst;
  worst.size = -kInfinity;
  const Eigen::Index instants = basis_.time.size();
  for (Eigen::Index row = 0; row < values.size(); ++row) {
    const double size = std::max(values[row] - upper_[row], lower_[row] - values[row]);
    const auto at = static_cast<size_t>(row / instants);
    if (size > worst.size) worst = {size, at < kept_.size() ? kept_[at] : spans_[row - instants * static_cast<Eigen::Index>(kept_.size())].joint};
  }
  return worst;
}

SearchProgram::SearchProgram(const MotionObjective& objective, const GridConstraints& limits,
                             int variables)
    : objective_(objective), limits_(limits), variables_(variables) {}

double SearchProgram::objective(const VectorXd& x) {
  ++evaluations_;
  there_ = objective_.at(x);
  objective_at_ = x;
  evaluate_point();
  return there_.value;
}

VectorXd SearchProgram::gradient(const VectorXd& x) {
  if (x.size() != objective_at_.size() || x != objective_at_) return objective_.gradient(x);
  return objective_.gradient(x, there_);
}

VectorXd SearchProgram::constraints(const VectorXd& x) {
  const VectorXd values = limits_.values(x);
  violation_ = limits_.violation(values);
  constraints_at_ = x;
  evaluate_point();
  return values;
}

void SearchProgram::evaluate_point() {
  if (objective_at_.size() != constraints_at_.size() || objective_at_ != constraints_at_) return;
  if (violation_.size > kHeld || (best_ && best_->value <= there_.value)) return;
  best_ = Best{objective_at_, there_.value, violation_};
}

WidestViolation::WidestViolation(const GridConstraints& limits, int variables)
    : limits_(limits), variables_(variables) {
  const Eigen::Index rows = limits.lower().size();
  // Constraints c - t <= upper and c + t >= lower.
  lower_ = VectorXd::Constant(2 * rows, -kInfinity);
  upper_ = VectorXd::Constant(2 * rows, kInfinity);
  upper_.head(rows) = limits.upper();
  lower_.tail(rows) = limits.lower();
  for (int side = 0; side < 2; ++side) {
    const int shift = side * static_cast<int>(rows);
    for (const auto& [row, column] : limits.pattern()) pattern_.emplace_back(row + shift, column);
    for (int row = limits.joint_rows(); row < rows; ++row)
      pattern_.emplace_back(row + shift, variables);
  }
}

double WidestViolation::objective(const VectorXd& x) {
  return x[variables_] + 0.5 * kPullBack * x.squaredNorm();
}

VectorXd WidestViolation::gradient(const VectorXd& x) {
  VectorXd out = kPullBack * x;
  out[variables_] += 1.0;
  return out;
}

VectorXd WidestViolation::constraints(const VectorXd& x) {
  const VectorXd values = limits_.values(x.head(variables_));
  VectorXd out(2 * values.size());
  out << values, values;
  const Eigen::Index widened = values.size() - limits_.joint_rows();
  out.segment(limits_.joint_rows(), widened).array() -= x[variables_];
  out.tail(widened).array() += x[variables_];
  return out;
}

VectorXd WidestViolation::jacobian(const VectorXd& x) {
  const VectorXd inner = limits_.jacobian(x.head(variables_));
  const Eigen::Index rows = limits_.lower().size() - limits_.joint_rows();
  VectorXd out(pattern_.size());
  out << inner, VectorXd::Constant(rows, -1.0), inner, VectorXd::Constant(rows, 1.0);
  return out;
}

}  // namespace veridyn
