#pragma once

#include "veridyn/math/types.hpp"

namespace veridyn {

/// Singular values of a square matrix, the largest first; NaN if an element is not finite. It replaces Eigen's
/// own decomposition, which frees memory twice if an allocation in it fails. Accuracy: rounding relative to the
/// largest one. Cost: O(n^3).
VectorXd singular_values(const MatrixXd& A);

}  // namespace veridyn
