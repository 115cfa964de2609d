#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

// Eigen's decompositions of the sizes used here are compiled once, in decompositions_*.cpp. A file that sees
// these declarations calls them instead of compiling its own copy, which costs 3 to 40 s each time.
// The library's and the tests' precompiled headers hold this file; nothing depends on it for its meaning.
namespace Eigen {

extern template class BDCSVD<MatrixXd>;
extern template class JacobiSVD<MatrixXd>;
extern template class ColPivHouseholderQR<MatrixXd>;
extern template class CompleteOrthogonalDecomposition<MatrixXd>;
extern template class HouseholderQR<MatrixXd>;
extern template class FullPivLU<MatrixXd>;
extern template class PartialPivLU<MatrixXd>;
extern template class LDLT<MatrixXd>;
extern template class LLT<MatrixXd>;
extern template class SelfAdjointEigenSolver<MatrixXd>;
extern template class SelfAdjointEigenSolver<Matrix3d>;
extern template class SelfAdjointEigenSolver<Matrix4d>;

}  // namespace Eigen
