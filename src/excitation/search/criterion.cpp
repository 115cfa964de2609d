#include "criterion.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <vector>

namespace veridyn {
namespace {

// Eigenvalues below this share of the largest are rounding errors; raising them to it makes the criterion
// large.
constexpr double kSmallestShare = 1e-15;

VectorXd inverse_norms(const MatrixXd& gram) {
  const double floor = 1e-300 + 1e-30 * gram.diagonal().maxCoeff();
  return gram.diagonal().cwiseMax(floor).cwiseSqrt().cwiseInverse();
}

MatrixXd scaled_both_sides(const MatrixXd& gram, const VectorXd& d) {
  return d.asDiagonal() * gram * d.asDiagonal();
}

// ln det of a positive matrix and its inverse; a ridge keeps both finite.
double log_det(const MatrixXd& A, MatrixXd& inverse) {
  const Eigen::Index n = A.rows();
  const double ridge = kSmallestShare * std::max(A.diagonal().maxCoeff(), 1e-300);
  const Eigen::LLT<MatrixXd> llt(A + ridge * MatrixXd::Identity(n, n));
  if (llt.info() == Eigen::Success) {
    inverse = llt.solve(MatrixXd::Identity(n, n));
    return 2.0 * llt.matrixLLT().diagonal().array().log().sum();
  }
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(A);
  const VectorXd values = eigen.eigenvalues().cwiseMax(ridge);
  inverse =
      eigen.eigenvectors() * values.cwiseInverse().asDiagonal() * eigen.eigenvectors().transpose();
  return values.array().log().sum();
}

}  // namespace

SmoothValue smooth_condition(const MatrixXd& gram, ColumnNorm norm, double sharpness) {
  const double p = sharpness;
  const bool one = norm == ColumnNorm::kOne;
  const VectorXd d = one ? inverse_norms(gram) : VectorXd::Ones(gram.rows());
  const MatrixXd C = scaled_both_sides(gram, d);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(C);
  const double largest = std::max(eigen.eigenvalues().maxCoeff(), 1e-300);
  const VectorXd e = eigen.eigenvalues().cwiseMax(kSmallestShare * largest);
  const double smallest = e.minCoeff();
  // Powers of ratios up to one cannot overflow.
  const Eigen::ArrayXd up = (e.array() / largest).pow(p);
  const Eigen::ArrayXd down = (smallest / e.array()).pow(p);
  SmoothValue out;
  out.value =
      0.5 * (std::log(largest / smallest) + (std::log(up.sum()) + std::log(down.sum())) / p);
  const VectorXd slope = (0.5 * (up / up.sum() - down / down.sum()) / e.array()).matrix();
  const MatrixXd& V = eigen.eigenvectors();
  const MatrixXd by_C = V * slope.asDiagonal() * V.transpose();
  out.by_gram = scaled_both_sides(by_C, d);
  // The scaling depends on the diagonal, which contributes to the derivative.
  if (one) {
    const VectorXd pull = by_C.cwiseProduct(C).rowwise().sum().cwiseProduct(d.cwiseAbs2());
    out.by_gram.diagonal() -= pull;
  }
  return out;
}

SmoothValue smooth_d_optimality(const MatrixXd& gram, const VectorXd& scale) {
  const VectorXd d = scale.cwiseInverse();
  SmoothValue out;
  MatrixXd inverse;
  const double share = -0.5 / static_cast<double>(gram.rows());
  out.value = share * log_det(scaled_both_sides(gram, d), inverse);
  out.by_gram = share * scaled_both_sides(inverse, d);
  return out;
}

namespace {

// A group of columns with the sizes of their parameters.
struct Group {
  Eigen::Index first;
  const VectorXd& sizes;
  std::vector<Eigen::Index> columns() const {
    std::vector<Eigen::Index> out;
    for (Eigen::Index k = 0; k < sizes.size(); ++k) out.push_back(first + k);
    return out;
  }
};

// The remainder of a group after regression on `others`, and its derivative by the scaled Gram
// matrix G.
double regression_remainder(const MatrixXd& G, const VectorXd& scale, const Group& group,
               const std::vector<Eigen::Index>& others, MatrixXd& by_gram) {
  const MatrixXd side = G(others, group.columns());
  MatrixXd inverse;
  log_det(G(others, others), inverse);
  const MatrixXd X = inverse * side;
  by_gram = MatrixXd::Zero(G.rows(), G.cols());
  double left = 0.0;
  for (Eigen::Index k = 0; k < group.sizes.size(); ++k) {
    const Eigen::Index own = group.first + k;
    const double unit = std::pow(group.sizes[k] * scale[own], 2);
    left += unit * std::max(G(own, own) - side.col(k).dot(X.col(k)), kSmallestShare * G(own, own));
    VectorXd direction = VectorXd::Zero(G.rows());
    direction[own] = 1.0;
    direction(others) = -X.col(k);
    by_gram += unit * direction * direction.transpose();
  }
  by_gram = scaled_both_sides(by_gram, scale.cwiseInverse());
  return left;
}

RivalLeft rival_remainder(const MatrixXd& gram, const VectorXd& scale, Eigen::Index nuisance,
                     const Group& group, const Group& other) {
  const MatrixXd G = scaled_both_sides(gram, scale.cwiseInverse());
  std::vector<Eigen::Index> others;
  for (Eigen::Index k = 0; k < nuisance; ++k) others.push_back(k);
  RivalLeft out;
  out.alone = regression_remainder(G, scale, group, others, out.alone_by_gram);
  const std::vector<Eigen::Index> rival = other.columns();
  others.insert(others.end(), rival.begin(), rival.end());
  out.left = regression_remainder(G, scale, group, others, out.left_by_gram);
  return out;
}

}  // namespace

std::pair<RivalLeft, RivalLeft> rival_remainders(const MatrixXd& gram, const VectorXd& scale,
                                            const RivalColumns& rivals) {
  const Eigen::Index n = rivals.nuisance;
  const Group first{n, rivals.first};
  const Group second{n + rivals.first.size(), rivals.second};
  return {rival_remainder(gram, scale, n, first, second), rival_remainder(gram, scale, n, second, first)};
}

SmoothValue smooth_discrimination(const MatrixXd& gram, const VectorXd& scale,
                                  const RivalColumns& rivals) {
  const auto both = rival_remainders(gram, scale, rivals);
  const bool first = !rivals.first.isZero(0.0);
  const bool second = !rivals.second.isZero(0.0);
  const double weight = first && second ? 0.5 : 1.0;
  SmoothValue out;
  out.by_gram = MatrixXd::Zero(gram.rows(), gram.cols());
  const auto add = [&](const RivalLeft& rival) {
    const double left = std::max(rival.left, 1e-300);
    const double alone = std::max(rival.alone, 1e-300);
    out.value += weight * (-0.5 * std::log(left) + 0.25 * std::log(alone));
    out.by_gram += weight * (-0.5 / left * rival.left_by_gram + 0.25 / alone * rival.alone_by_gram);
  };
  if (first) add(both.first);
  if (second) add(both.second);
  return out;
}

}  // namespace veridyn
