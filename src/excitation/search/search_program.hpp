#pragma once

#include <limits>

#include "excitation/limits/limit_signals.hpp"
#include "excitation/search/motion_objective.hpp"
#include "excitation/solvers/nonlinear_program.hpp"

namespace veridyn {

/// The limits of a motion on a grid of instants, as constraints on the coordinates of its space;
/// every signal is divided by its scale.
class GridConstraints {
 public:
  GridConstraints(const MotionSpace& space, const LimitSignals& signals, int instants);

  /// Sets the bounds of every signal; infinite if it is free. The initial bounds are those of the signals.
  void set_bounds(const VectorXd& lower, const VectorXd& upper);

  /// A joint's position at one instant of the grid exceeds that at another instant by at least `least` [rad]
  /// or [m].
  struct Span {
    int joint;
    Eigen::Index high, low;
    double least;
  };
  void set_spans(std::vector<Span> spans);

  const VectorXd& lower() const { return lower_; }
  const VectorXd& upper() const { return upper_; }
  const std::vector<std::pair<int, int>>& pattern() const { return pattern_; }
  /// Number of rows of the joints' ranges, speeds and accelerations, which come first.
  int joint_rows() const { return joint_rows_; }
  VectorXd values(const VectorXd& x) const;  ///< of all constraints
  VectorXd jacobian(const VectorXd& x) const;  ///< nonzero entries in the order of pattern()

  /// The largest violation of the bounds at x, relative to the scale, and its signal.
  struct Violation {
    double size = 0.0;
    int signal = 0;
  };
  Violation violation(const VectorXd& values) const;

 private:
  const MotionSpace& space_;
  const LimitSignals& signals_;
  MotionSpace::Basis basis_;
  std::vector<int> kept_;  // indices of the signals with a bound
  std::vector<Span> spans_;  // spans, whose rows are the last ones
  int joint_rows_ = 0;
  VectorXd lower_, upper_;
  std::vector<std::pair<int, int>> pattern_;
  VectorXd constant_;  // entries of the Jacobian for q, dq, ddq, which are constant
};

/// Minimises the criterion within the limits, and stores the best motion within them, independently of the
/// solver.
class SearchProgram final : public NonlinearProgram {
 public:
  SearchProgram(const MotionObjective& objective, const GridConstraints& limits, int variables);

  int variables() const override { return variables_; }
  double objective(const VectorXd& x) override;
  VectorXd gradient(const VectorXd& x) override;
  const VectorXd& lower() const override { return limits_.lower(); }
  const VectorXd& upper() const override { return limits_.upper(); }
  VectorXd constraints(const VectorXd& x) override;
  const std::vector<std::pair<int, int>>& pattern() const override { return limits_.pattern(); }
  VectorXd jacobian(const VectorXd& x) override { return limits_.jacobian(x); }

  /// The best evaluated motion within the limits.
  struct Best {
    VectorXd x;
    double value = std::numeric_limits<double>::infinity();
    GridConstraints::Violation violation{};
  };
  const std::optional<Best>& best() const { return best_; }
  int evaluations() const { return evaluations_; }

 private:
  void evaluate_point();

  const MotionObjective& objective_;
  const GridConstraints& limits_;
  int variables_;
  VectorXd objective_at_, constraints_at_;
  SmoothValue there_;  // criterion at objective_at_
  GridConstraints::Violation violation_{};
  std::optional<Best> best_;
  int evaluations_ = 0;
};

/// Minimises t such that all limits hold if those of torques and positions in space are widened by t times
/// their scale. They can be satisfied if t <= 0; else t is the violation. The last variable is t.
class WidestViolation final : public NonlinearProgram {
 public:
  explicit WidestViolation(const GridConstraints& limits, int variables);

  int variables() const override { return variables_ + 1; }
  double objective(const VectorXd& x) override;
  VectorXd gradient(const VectorXd& x) override;
  const VectorXd& lower() const override { return lower_; }
  const VectorXd& upper() const override { return upper_; }
  VectorXd constraints(const VectorXd& x) override;
  const std::vector<std::pair<int, int>>& pattern() const override { return pattern_; }
  VectorXd jacobian(const VectorXd& x) override;

 private:
  const GridConstraints& limits_;
  int variables_;
  VectorXd lower_, upper_;
  std::vector<std::pair<int, int>> pattern_;
};

}  // namespace veridyn
