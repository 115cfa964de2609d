#include "criterion.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <vector>

namespace veridyn {
namespace {

// Eigenvalues below this share of the largest are rounding errors: the search sees a wall there and
// not a hole.
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
  // Powers of ratios at most one: nothing overflows.
  const Eigen::ArrayXd up = (e.array() / largest).pow(p);
  const Eigen::ArrayXd down = (smallest / e.array()).pow(p);
  SmoothValue out;
  out.value =
      0.5 * (std::log(largest / smallest) + (std::log(up.sum()) + std::log(down.sum())) / p);
  const VectorXd slope = (0.5 * (up / up.sum() - down / down.sum()) / e.array()).matrix();
  const MatrixXd& V = eigen.eigenvectors();
  const MatrixXd by_C = V * slope.asDiagonal() * V.transpose();
  out.by_gram = scaled_both_sides(by_C, d);
  // The norms depend on the diagonal.
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

SmoothValue smooth_discrimination(const MatrixXd& gram, const VectorXd& scale,
                                  const RivalColumns& rivals) {
  const VectorXd d = scale.cwiseInverse();
  const MatrixXd G = scaled_both_sides(gram, d);
  const Eigen::Index n = rivals.nuisance;
  const Eigen::Index a = rivals.first;
  const Eigen::Index b = rivals.second;
  SmoothValue out;
  MatrixXd by_scaled = MatrixXd::Zero(G.rows(), G.cols());
  MatrixXd inverse;
  const auto add = [&](const std::vector<Eigen::Index>& kept, double weight) {
    out.value += weight * log_det(G(kept, kept), inverse);
    by_scaled(kept, kept) += weight * inverse;
  };
  std::vector<Eigen::Index> all;
  std::vector<Eigen::Index> without_a;
  std::vector<Eigen::Index> without_b;
  for (Eigen::Index k = 0; k < n + a + b; ++k) {
    all.push_back(k);
    if (k < n || k >= n + a) without_a.push_back(k);
    if (k < n + a) without_b.push_back(k);
  }
  const double weight_a = -0.25 / static_cast<double>(a);
  const double weight_b = -0.25 / static_cast<double>(b);
  add(all, weight_a + weight_b);
  add(without_a, -weight_a);
  add(without_b, -weight_b);
  out.by_gram = scaled_both_sides(by_scaled, d);
  return out;
}

}  // namespace veridyn
