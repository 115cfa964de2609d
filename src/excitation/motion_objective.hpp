#pragma once

#include <functional>
#include <memory>

#include "criterion.hpp"
#include "motion_space.hpp"
#include "stacked_columns.hpp"

namespace veridyn {

/// What a search wants to be small, as a function of the coordinates of a MotionSpace, with its
/// exact gradient: criterion <- Gram matrix <- regressor <- q, dq, ddq <- coordinates.
class MotionObjective {
 public:
  using Criterion = std::function<SmoothValue(const MatrixXd& gram)>;

  /// @param given         (chosen x chosen) information that is there already, per instant of this
  ///                      motion; zero where there is none.
  MotionObjective(const MotionSpace& space, std::shared_ptr<const StackedColumns> columns,
                  VectorXd row_weights, MatrixXd given, Criterion criterion, int instants);

  double value(const VectorXd& x) const;
  VectorXd gradient(const VectorXd& x) const;

  /// The Gram matrix per instant, with what is given.
  MatrixXd gram(const VectorXd& x) const;

 private:
  const MotionSpace& space_;
  std::shared_ptr<const StackedColumns> columns_;
  VectorXd row_weights_;
  MatrixXd given_;
  Criterion criterion_;
  MotionSpace::Basis basis_;
};

}  // namespace veridyn
