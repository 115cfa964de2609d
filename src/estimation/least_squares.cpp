#include "estimation/least_squares.hpp"

#include "math/decompositions.hpp"

namespace veridyn {

VectorXd least_squares(const SquareRootInformation& factor) {
  return Eigen::ColPivHouseholderQR<MatrixXd>(factor.R()).solve(factor.z());
}

VectorXd normal_solution(const MatrixXd& A, const VectorXd& b) {
  return Eigen::LDLT<MatrixXd>(A).solve(b);
}

}  // namespace veridyn
