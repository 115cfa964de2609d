#include "identification/estimation/least_squares.hpp"

#include "math/decompositions.hpp"

namespace veridyn {

VectorXd least_squares(const SquareRootInformation& factor) {
  return Eigen::ColPivHouseholderQR<MatrixXd>(factor.R()).solve(factor.z());
}

MatrixXd solutions_without(const std::vector<SquareRootInformation>& blocks) {
  const size_t count = blocks.size();
  if (count == 0) return {};
  const SquareRootInformation none(blocks.front().columns());
  std::vector<SquareRootInformation> after(count, none);
  for (size_t b = count - 1; b > 0; --b) {
    after[b - 1] = after[b];
    after[b - 1].merge(blocks[b]);
  }
  SquareRootInformation before = none;
  MatrixXd out(none.size(), static_cast<Eigen::Index>(count));
  for (size_t b = 0; b < count; ++b) {
    SquareRootInformation rest = before;
    rest.merge(after[b]);
    out.col(b) = least_squares(rest);
    before.merge(blocks[b]);
  }
  return out;
}

VectorXd normal_solution(const MatrixXd& A, const VectorXd& b) {
  return Eigen::LDLT<MatrixXd>(A).solve(b);
}

}  // namespace veridyn
