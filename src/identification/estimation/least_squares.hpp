#pragma once

#include <vector>

#include "veridyn/math/square_root_information.hpp"

namespace veridyn {

/// The least-squares solution of a factor, R x = z, by a rank-revealing decomposition.
VectorXd least_squares(const SquareRootInformation& factor);

/// Solutions that leave out one block each (columns x blocks), as a jackknife needs them: the blocks before
/// the omitted one are merged with those after it.
MatrixXd solutions_without(const std::vector<SquareRootInformation>& blocks);

/// Solves normal equations A x = b with a symmetric A.
VectorXd normal_solution(const MatrixXd& A, const VectorXd& b);

}  // namespace veridyn
