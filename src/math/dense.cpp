#include "math/dense.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>

namespace veridyn {

MatrixXd orthonormal_basis(const MatrixRef& columns) {
  if (columns.cols() == 0) return columns;  // Eigen would read the largest entry of an empty vector
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(columns);
  return MatrixXd(qr.householderQ()).leftCols(qr.rank());
}

VectorXd least_norm(const MatrixRef& A, const VectorRef& b) {
  return Eigen::CompleteOrthogonalDecomposition<MatrixXd>(A).solve(b);
}

VectorXd least_squares_solution(const MatrixRef& A, const VectorRef& b) {
  return Eigen::ColPivHouseholderQR<MatrixXd>(A).solve(b);
}

VectorXd symmetric_solution(const MatrixRef& A, const VectorRef& b) {
  return Eigen::LDLT<MatrixXd>(A).solve(b);
}

}  // namespace veridyn
