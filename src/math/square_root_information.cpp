#include "veridyn/math/square_root_information.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <unordered_map>
#include <utility>

#include "veridyn/math/require.hpp"

namespace veridyn {

SquareRootInformation::SquareRootInformation(std::vector<std::string> columns)
    : columns_(std::move(columns)),
      R_(MatrixXd::Zero(size(), size())),
      z_(VectorXd::Zero(size())) {}

// Triangulates [A b] in place and keeps its first size() rows; what b has left below them goes into
// rho^2.
void SquareRootInformation::absorb_stacked(MatrixXd stacked) {
  const int k = size();
  const Eigen::HouseholderQR<Eigen::Ref<MatrixXd>> qr(stacked);
  const Eigen::Index kept = std::min<Eigen::Index>(k, stacked.rows());
  R_.setZero();
  z_.setZero();
  R_.topRows(kept) = stacked.topLeftCorner(kept, k).triangularView<Eigen::Upper>();
  z_.head(kept) = stacked.col(k).head(kept);
  if (stacked.rows() > k) rho2_ += stacked(k, k) * stacked(k, k);
}

void SquareRootInformation::absorb(const MatrixRef& A, const VectorRef& b) {
  const int k = size();
  require(A.cols() == k && A.rows() == b.size(), "SquareRootInformation::absorb: A is (", A.rows(),
          " x ", A.cols(), ") and b has ", b.size(), " rows; expected ", k,
          " columns and equal rows.");
  // Blocks much taller than wide, so that the triangle on top costs little.
  const Eigen::Index block = std::max<Eigen::Index>(256, 4 * k);
  for (Eigen::Index at = 0; at < A.rows(); at += block) {
    const Eigen::Index n = std::min(block, A.rows() - at);
    MatrixXd stacked(k + n, k + 1);
    stacked.topLeftCorner(k, k) = R_;
    stacked.topRightCorner(k, 1) = z_;
    stacked.bottomLeftCorner(n, k) = A.middleRows(at, n);
    stacked.bottomRightCorner(n, 1) = b.segment(at, n);
    absorb_stacked(std::move(stacked));
  }
  rows_ += static_cast<double>(A.rows());
}

void SquareRootInformation::merge(const SquareRootInformation& other, double weight) {
  std::unordered_map<std::string, int> index;
  for (int i = 0; i < size(); ++i) index.emplace(columns_[i], i);
  std::vector<int> place(other.columns_.size());
  std::vector<std::string> added;
  for (size_t j = 0; j < other.columns_.size(); ++j) {
    const auto found = index.find(other.columns_[j]);
    place[j] = found != index.end() ? found->second : size() + static_cast<int>(added.size());
    if (found == index.end()) added.push_back(other.columns_[j]);
  }
  const int before = size();
  columns_.insert(columns_.end(), added.begin(), added.end());
  const int k = size();
  const int m = other.size();
  MatrixXd stacked = MatrixXd::Zero(before + m, k + 1);
  stacked.topLeftCorner(before, before) = R_;
  stacked.topRightCorner(before, 1) = z_;
  for (int j = 0; j < m; ++j)
    stacked.col(place[static_cast<size_t>(j)]).tail(m) = weight * other.R_.col(j);
  stacked.col(k).tail(m) = weight * other.z_;
  R_.resize(k, k);
  z_.resize(k);
  absorb_stacked(std::move(stacked));
  rho2_ += weight * weight * other.rho2_;
  rows_ += other.rows_;
}

double SquareRootInformation::residual2(const VectorRef& x) const {
  return (R_ * x - z_).squaredNorm() + rho2_;
}

SquareRootInformation SquareRootInformation::restricted(
    const std::vector<std::string>& columns) const {
  std::unordered_map<std::string, int> index;
  for (int i = 0; i < size(); ++i) index.emplace(columns_[i], i);
  MatrixXd T = MatrixXd::Zero(size(), static_cast<Eigen::Index>(columns.size()));
  for (size_t j = 0; j < columns.size(); ++j) {
    const auto found = index.find(columns[j]);
    if (found != index.end()) T(found->second, static_cast<Eigen::Index>(j)) = 1.0;
  }
  return transformed(T, columns);
}

SquareRootInformation SquareRootInformation::transformed(const MatrixRef& T,
                                                         std::vector<std::string> columns) const {
  SquareRootInformation out(std::move(columns));
  out.absorb(R_.triangularView<Eigen::Upper>() * T, z_);
  out.rho2_ += rho2_;
  out.rows_ = rows_;
  return out;
}

VectorXd SquareRootInformation::column_norms() const {
  return R_.colwise().norm().transpose();
}

}  // namespace veridyn
