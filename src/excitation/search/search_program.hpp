#pragma once

#include <limits>

#include "excitation/limits/limit_signals.hpp"
#include "excitation/search/motion_objective.hpp"
#include "excitation/search/nonlinear_program.hpp"

namespace veridyn {

/// The limits of a motion on a grid of instants, as constraints on the coordinates of its space;
/// every signal is divided by its scale.
class GridConstraints {
 public:
  GridConstraints(const MotionSpace& space, const LimitSignals& signals, int instants);

  /// Bounds of every signal; infinite where it is free. At first those of the signals.
  void set_bounds(const VectorXd& lower, const VectorXd& upper);

  const VectorXd& lower() const { return lower_; }
  const VectorXd& upper() const { return upper_; }
  const std::vector<std::pair<int, int>>& pattern() const { return pattern_; }
  /// Rows of the joints' ranges, speeds and accelerations, which come first.
  int joint_rows() const { return joint_rows_; }
  VectorXd values(const VectorXd& x) const;
  VectorXd jacobian(const VectorXd& x) const;

  /// By how much x leaves the bounds, at most, in shares of the scale; and which signal does.
  struct Violation {
    double size = 0.0;
    int signal = -1;
  };
  Violation violation(const VectorXd& values) const;

 private:
  const MotionSpace& space_;
  const LimitSignals& signals_;
  MotionSpace::Basis basis_;
  std::vector<int> kept_;  // signals with a bound
  int joint_rows_ = 0;
  VectorXd lower_, upper_;
  std::vector<std::pair<int, int>> pattern_;
  VectorXd constant_;  // entries of the Jacobian that belong to q, dq, ddq
};

/// The smallest criterion within the limits. Remembers the best motion that keeps them, whatever
/// the solver does.
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

  /// The best so far within the limits, as far as the solver has asked.
  struct Best {
    VectorXd x;
    double value = std::numeric_limits<double>::infinity();
    GridConstraints::Violation violation{};
  };
  const std::optional<Best>& best() const { return best_; }
  int evaluations() const { return evaluations_; }

 private:
  void look();

  const MotionObjective& objective_;
  const GridConstraints& limits_;
  int variables_;
  VectorXd objective_at_, constraints_at_;
  SmoothValue there_;  // at objective_at_
  GridConstraints::Violation violation_{};
  std::optional<Best> best_;
  int evaluations_ = 0;
};

/// The smallest t such that all limits hold when those of torques and places are widened by t times
/// their scale: whether they can be met at all, and by how much not. The last variable is t.
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
