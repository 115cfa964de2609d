#pragma once

#include "veridyn/math/types.hpp"

namespace veridyn {

/// An orthonormal basis of the columns' span, (rows x rank).
MatrixXd orthonormal_basis(const MatrixRef& columns);

/// The shortest x with A x = b (in the least-squares sense where there is none); by complete
/// orthogonal decomposition.
VectorXd least_norm(const MatrixRef& A, const VectorRef& b);

}  // namespace veridyn
