#pragma once

#include <vector>

#include "excitation/base_regressor.hpp"
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
///   ln( 1/p sum_b sqrt(inv(M)_bb) / size_b )
///   M = sum_i (G_i + given_i) / (share_i^2 (beta' G_i beta + least_i^2))
///
/// with the Gram matrix G_i per instant of joint i, the values beta, and the noise of each joint's
/// torque as a share of its rms along the motion: what predict_identification() calls
/// mean_relative, up to a factor that no motion changes, but for two floors. A noise does not
/// vanish with the torque: least_i is kLeastTorque of the joint's rms torque at random states;
/// otherwise motions would win along which the torques of an arm with just these values cancel.
/// And size_b is |beta_b|, but at least the size of a parameter that makes kFloorOfTorque of all
/// torques at random states: nobody asks how well nothing is known relative to itself.
class RelativeDeviations {
 public:
  static constexpr double kFloorOfTorque = 1e-3;
  static constexpr double kLeastTorque = 0.1;

  /// @param arm    with values.
  /// @param share  (n) of the noise.
  /// @param given  (n of size x size) information that is there already, per instant of the new
  ///               motion.
  RelativeDeviations(const Model& arm, const BaseRegressor& regressor, VectorXd share,
                     std::vector<MatrixXd> given);

  /// What the deviations are relative to.
  const VectorXd& size() const { return size_; }

  /// (n) squares of least_i.
  const VectorXd& least_square() const { return least_square_; }

  SmoothJointValue operator()(const std::vector<MatrixXd>& grams) const;

 private:
  VectorXd beta_, size_, share_;
  std::vector<MatrixXd> given_;
  VectorXd least_square_;
};

}  // namespace veridyn
