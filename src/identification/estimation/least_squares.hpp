#pragma once

#include <vector>

#include "veridyn/math/square_root_information.hpp"

namespace veridyn {

/// The least-squares solution of a factor, R x = z, by a rank-revealing decomposition.
VectorXd least_squares(const SquareRootInformation& factor);

/// (columns x blocks) Solutions of all blocks but one each, as a jackknife needs them: the blocks before the one that
/// is left out are merged with those after it.
MatrixXd solutions_without(const std::vector<SquareRootInformation>& blocks);

/// Solves normal equations A x = b with a symmetric A.
VectorXd normal_solution(const MatrixXd& A, const VectorXd& b);

}  // namespace veridyn
