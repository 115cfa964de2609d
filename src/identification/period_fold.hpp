#pragma once

#include <deque>

#include "veridyn/math/types.hpp"

namespace veridyn {

/// Compares torques with those one period earlier; the difference between repeats is the error of a perfect
/// model. Stores one period of samples.
class PeriodFold {
 public:
  /// @param period  [s]; 0: nothing is compared.
  PeriodFold(int joints, double period);

  /// Adds row `row` of tau, at `time` [s]; times increase.
  void add(double time, const MatrixXd& tau, Eigen::Index row);

  /// Noise floor (joints): standard deviation of one repeat over the root mean square of the torque; empty
  /// where nothing repeats. The difference of two repeats has twice the variance of one.
  VectorXd relative_floor() const;

 private:
  struct Sample {
    double time;
    VectorXd tau;
  };
  double period_, adjacent_;
  std::deque<Sample> past_;
  VectorXd difference2_;
  VectorXd torque2_;
  bool compared_ = false;
};

}  // namespace veridyn
