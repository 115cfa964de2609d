#pragma once

#include <functional>
#include <memory>

#include "excitation/a_optimality.hpp"
#include "excitation/criterion.hpp"
#include "excitation/search/motion_space.hpp"
#include "regressor/stacked_columns.hpp"

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

  /// @param criterion  of the Gram matrices of every joint's rows, per instant.
  using JointCriterion = std::function<SmoothJointValue(const std::vector<MatrixXd>& grams)>;
  MotionObjective(const MotionSpace& space, std::shared_ptr<const StackedColumns> columns,
                  JointCriterion criterion, int instants);

  double value(const VectorXd& x) const { return at(x).value; }
  VectorXd gradient(const VectorXd& x) const { return gradient(x, at(x)); }

  /// The value, and what the gradient needs beside x.
  SmoothJointValue at(const VectorXd& x) const;
  VectorXd gradient(const VectorXd& x, const SmoothJointValue& at_x) const;

 private:
  std::vector<MatrixXd> grams(const MotionSamples& motion) const;

  const MotionSpace& space_;
  std::shared_ptr<const StackedColumns> columns_;
  JointCriterion criterion_;
  MotionSpace::Basis basis_;
};

}  // namespace veridyn
