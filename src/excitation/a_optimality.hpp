#pragma once

#include <vector>

#include "veridyn/excitation/base_regressor.hpp"
#include "veridyn/excitation/excitation.hpp"

namespace veridyn {

/// A function of the Gram matrices of every joint's rows, with its derivatives by each of them.
struct SmoothJointValue {
  double value = 0.0;
  std::vector<MatrixXd> by_gram;
};

/// How well least squares would know the base parameters after a motion (A-optimality with relative
/// deviations):
///
///   ln( 1/p sum_b sqrt(inv(M)_bb) / size_b ),   M = sum_i (G_i + given_i) / (share_i^2 beta' G_i
///   beta)
///
/// with the Gram matrix G_i per instant of joint i, the noise of each joint's torque as a share of
/// its rms along the motion, and the values beta: what predict_identification() calls
/// mean_relative, up to a factor that no motion changes. Sizes are the parameters' own, but at
/// least that of a parameter whose torque is kFloorOfTorque of all torques at random states: nobody
/// asks how well nothing is known relative to itself.
class RelativeDeviations {
 public:
  static constexpr double kFloorOfTorque = 1e-3;

  /// @param arm    with values.
  /// @param share  (n) of the noise.
  /// @param given  (n of size x size) information that is there already, per instant of the new
  ///               motion.
  RelativeDeviations(const Model& arm, const BaseRegressor& regressor, VectorXd share,
                     std::vector<MatrixXd> given);

  /// What the deviations are relative to.
  const VectorXd& size() const { return size_; }

  SmoothJointValue operator()(const std::vector<MatrixXd>& grams) const;

 private:
  VectorXd beta_, size_, share_;
  std::vector<MatrixXd> given_;
  double least_square_ = 0.0;  // of a joint's torque, so that one without any has some noise
};

}  // namespace veridyn
