#pragma once

#include "excitation/search/base_regressor.hpp"
#include "excitation/search/criterion.hpp"

namespace veridyn {

/// Reference sizes of the base parameters' relative deviations: |beta_b|, but at least that of a
/// parameter that makes kFloorOfTorque of all torques at random states, because a deviation
/// relative to zero is meaningless.
/// @param arm  with values.
constexpr double kFloorOfTorque = 1e-3;
VectorXd parameter_sizes(const Model& arm, const BaseRegressor& regressor);

/// A-optimality with relative deviations: the accuracy of the base parameters in least squares,
/// with the Gram matrix G of rows divided by their noise:
///
///   ln( 1/p sum_b sqrt(inv(G)_bb) / size_b )
///
/// It equals mean_relative of predict_identification(), up to a factor that does not depend on the
/// motion.
SmoothValue smooth_a_optimality(const MatrixXd& gram, const VectorXd& size);

}  // namespace veridyn
