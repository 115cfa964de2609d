#pragma once

#include "veridyn/math/types.hpp"

namespace veridyn {

/// An orthonormal basis of the columns' span, (rows x rank).
MatrixXd orthonormal_basis(const MatrixRef& columns);

/// The least-norm x with A x = b, or the least-norm least-squares solution; by complete orthogonal
/// decomposition.
VectorXd least_norm(const MatrixRef& A, const VectorRef& b);

/// The x that minimises |A x - b|; by QR with column pivoting. It is a function because each file that
/// instantiates A.colPivHouseholderQr() for an expression takes seconds longer to compile.
VectorXd least_squares_solution(const MatrixRef& A, const VectorRef& b);

/// Solves A x = b for a symmetric A; by LDLT.
VectorXd symmetric_solution(const MatrixRef& A, const VectorRef& b);

}  // namespace veridyn
