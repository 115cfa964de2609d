#pragma once

#include <functional>
#include <memory>

#include "excitation/search/criterion.hpp"
#include "excitation/search/motion_space.hpp"
#include "regressor/stacked_columns.hpp"

namespace veridyn {

/// Objective of a search as a function of the coordinates of a MotionSpace, with its exact
/// gradient: criterion <- Gram matrix <- regressor <- q, dq, ddq <- coordinates.
class MotionObjective {
 public:
  using Criterion = std::function<SmoothValue(const MatrixXd& gram)>;

  /// @param given         (chosen x chosen) information of earlier recordings, per instant of this
  /// motion; zero without any.
  MotionObjective(const MotionSpace& space, std::shared_ptr<const StackedColumns> columns,
                  VectorXd row_weights, MatrixXd given, Criterion criterion, int instants);

  double value(const VectorXd& x) const { return at(x).value; }
  VectorXd gradient(const VectorXd& x) const { return gradient(x, at(x)); }

  /// The value at x; stores the data for its gradient.
  SmoothValue at(const VectorXd& x) const;
  VectorXd gradient(const VectorXd& x, const SmoothValue& at_x) const;

 private:
  const MotionSpace& space_;
  std::shared_ptr<const StackedColumns> columns_;
  VectorXd row_weights_;
  MatrixXd given_;
  Criterion criterion_;
  MotionSpace::Basis basis_;
};

}  // namespace veridyn
