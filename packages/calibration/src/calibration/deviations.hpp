#pragma once

#include <vector>

#include "veridyn/math/types.hpp"

namespace veridyn {
constexpr double kDegree = 0.017453292519943295;  ///< [rad]
}

namespace veridyn::internal {

/// Standard deviation of normal values, from the median of their magnitudes, robust against
/// outliers.
double robust_deviation(std::vector<double> values);

/// Standard deviation of one component of 3-vectors, from their lengths; equally robust.
double robust_deviation_of_lengths(std::vector<double> lengths);

/// The distance that an error with this covariance exceeds in 5 of 100 cases: the norm of a normal vector, by
/// a scaled chi-square distribution with the same mean and variance (Satterthwaite, 1946).
/// @param degrees_of_freedom  of the estimated scale of the covariance.
double error_radius(const MatrixRef& covariance, double degrees_of_freedom);

/// Half width of the 95 % interval of a value, by Student's t, from its variance and the degrees of freedom of
/// that variance.
double half_width(double variance, double degrees_of_freedom);

/// Factor by which the variance of a mean exceeds that of independent values, from residuals in the
/// order of time: 1 + 2 sum of correlations, up to the first below 0.05. At least one.
/// @param series  one per channel; a missing residual is NaN.
double correlation_factor(const std::vector<std::vector<double>>& series);

}  // namespace veridyn::internal
