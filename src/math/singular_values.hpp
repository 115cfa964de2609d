#pragma once

#include "veridyn/math/types.hpp"

namespace veridyn {

/// Singular values of a square matrix, the largest first. Eigen's own decomposition frees memory twice
/// where an allocation in it fails. Accuracy: rounding relative to the largest. Cost: as a QR decomposition.
VectorXd singular_values(const MatrixXd& A);

}  // namespace veridyn
