#include "math/singular_values.hpp"

#include <limits>

#include "math/decompositions.hpp"

namespace veridyn {

// Computes singular values by Golub and Kahan: the eigenvalues of [0 B'; B 0] are plus and minus the singular
// values of the bidiagonal B = U' A V. If its rows and columns are interleaved, that matrix is tridiagonal with
// a zero diagonal.
VectorXd singular_values(const MatrixXd& A) {
  const Eigen::Index n = A.cols();
  if (n == 0) return {};
  if (!A.allFinite()) return VectorXd::Constant(n, std::numeric_limits<double>::quiet_NaN());
  const double scale = A.cwiseAbs().maxCoeff();
  if (!(scale > 0.0)) return VectorXd::Zero(n);
  const MatrixXd B = Eigen::internal::UpperBidiagonalization<MatrixXd>(A / scale).bidiagonal().toDenseMatrix();
  VectorXd beside(2 * n - 1);
  for (Eigen::Index k = 0; k < n; ++k) {
    beside[2 * k] = B(k, k);
    if (k + 1 < n) beside[2 * k + 1] = B(k, k + 1);
  }
  Eigen::SelfAdjointEigenSolver<MatrixXd> both;
  both.computeFromTridiagonal(VectorXd::Zero(2 * n), beside, Eigen::EigenvaluesOnly);
  if (both.info() != Eigen::Success) return Eigen::JacobiSVD<MatrixXd>(A).singularValues();
  return scale * both.eigenvalues().tail(n).reverse().cwiseMax(0.0);
}

}  // namespace veridyn
