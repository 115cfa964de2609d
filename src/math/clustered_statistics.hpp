#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "veridyn/math/types.hpp"

namespace veridyn {

/// Statistics of estimates over clusters by the jackknife: `without` (k x g) holds the estimates that leave one
/// of g clusters out, and their covariance is
///
///   C = (g - 1) / g * sum_c (x_c - mean x) (x_c - mean x)'
///
/// Efron and Stein, Annals of Statistics 9(3), 1981.

/// A factor F of the covariance, C = F F', (k x g).
inline MatrixXd jackknife_factor(const MatrixXd& without) {
  const auto g = static_cast<double>(without.cols());
  const VectorXd mean = without.rowwise().mean();
  return (without.colwise() - mean) * std::sqrt((g - 1.0) / g);
}

/// The standard deviations of the estimates, (k).
inline VectorXd jackknife_deviations(const MatrixXd& without) {
  const auto g = static_cast<double>(without.cols());
  const MatrixXd centred = without.colwise() - without.rowwise().mean();
  return (centred.rowwise().squaredNorm() * ((g - 1.0) / g)).cwiseSqrt();
}

}  // namespace veridyn
