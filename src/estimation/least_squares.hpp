#pragma once

#include "veridyn/math/square_root_information.hpp"

namespace veridyn {

/// The least-squares solution of a factor, R x = z, by a rank-revealing decomposition.
VectorXd least_squares(const SquareRootInformation& factor);

/// Solves normal equations A x = b with a symmetric A.
VectorXd normal_solution(const MatrixXd& A, const VectorXd& b);

}  // namespace veridyn
