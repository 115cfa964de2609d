#pragma once

#include "excitation/search/base_regressor.hpp"
#include "excitation/search/criterion.hpp"

namespace veridyn {

/// What the deviations of the base parameters are relative to: |beta_b|, but at least the size of a
/// parameter that makes kFloorOfTorque of all torques at random states: nobody asks how well nothing
/// is known relative to itself.
/// @param arm  with values.
constexpr double kFloorOfTorque = 1e-3;
VectorXd parameter_sizes(const Model& arm, const BaseRegressor& regressor);

/// How well least squares would know the base parameters (A-optimality with relative deviations),
/// with the Gram matrix G of rows divided by their noise:
///
///   ln( 1/p sum_b sqrt(inv(G)_bb) / size_b )
///
/// It is what predict_identification() calls mean_relative, up to a factor that no motion changes.
SmoothValue smooth_a_optimality(const MatrixXd& gram, const VectorXd& size);

}  // namespace veridyn
