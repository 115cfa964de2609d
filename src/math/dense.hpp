#pragma once

#include "veridyn/math/types.hpp"

namespace veridyn {

/// An orthonormal basis of the columns' span, (rows x rank).
MatrixXd orthonormal_basis(const MatrixRef& columns);

/// The shortest x with A x = b (in the least-squares sense where there is none); by complete
/// orthogonal decomposition.
VectorXd least_norm(const MatrixRef& A, const VectorRef& b);

/// The x with the least |A x - b|; by QR with column pivoting. (A.colPivHouseholderQr() of another
/// expression compiles the decomposition anew wherever it stands: seconds each.)
VectorXd least_squares_solution(const MatrixRef& A, const VectorRef& b);

/// A x = b for a symmetric A; by LDLT.
VectorXd symmetric_solution(const MatrixRef& A, const VectorRef& b);

}  // namespace veridyn
