#include "veridyn/math/square_root_information.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "aligned_doubles.hpp"
#include "triangle_update.hpp"
#include "math/parallel.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr Eigen::Index kBlockRows = 256;      // rows of a block: 60 columns are half of a 256 KiB cache
constexpr Eigen::Index kPieceRows = 1 << 15;  // rows of a thread's piece

}  // namespace

// The factor [R z; 0 rho] in the layout of the kernels, and a block of rows below it.
class SquareRootInformation::Triangle {
 public:
  Triangle(const SquareRootInformation& of, Eigen::Index rows)
      : k_(of.size()),
        columns_(triangle_columns(static_cast<int>(k_) + 1)),
        stride_(triangle_stride(static_cast<int>(k_) + 1)),
        rows_((rows + kTriangleRows - 1) / kTriangleRows * kTriangleRows) {
    thread_local AlignedDoubles memory;
    const auto top = static_cast<size_t>(columns_ * stride_);
    R_ = memory.zeros(top + static_cast<size_t>(rows_ * stride_));
    A_ = R_ + top;
    for (Eigen::Index j = 0; j < of.R_.cols(); ++j)
      for (Eigen::Index i = 0; i <= j; ++i) R_[i * stride_ + j] = of.R_(i, j);
    for (Eigen::Index i = 0; i < of.z_.size(); ++i) R_[i * stride_ + k_] = of.z_[i];
    R_[k_ * stride_ + k_] = std::sqrt(of.rho2_);
  }

  double& row(Eigen::Index i, Eigen::Index j) { return A_[i * stride_ + j]; }

  void clear_rows_from(Eigen::Index first) {
    std::fill(A_ + first * stride_, A_ + rows_ * stride_, 0.0);
  }

  // Column j of the block's first rows.
  template <typename Column>
  void set_column(Eigen::Index j, const Column& values) {
    double* to = A_ + j;
    for (Eigen::Index i = 0; i < values.size(); ++i) to[i * stride_] = values[i];
  }

  void update(bool triangular) {
    triangle_kernels().update({R_, A_, stride_, columns_, static_cast<int>(rows_), triangular});
  }

  void give_to(SquareRootInformation& to) const {
    for (Eigen::Index j = 0; j < k_; ++j)
      for (Eigen::Index i = 0; i <= j; ++i) to.R_(i, j) = R_[i * stride_ + j];
    for (Eigen::Index i = 0; i < k_; ++i) to.z_[i] = R_[i * stride_ + k_];
    to.rho2_ = R_[k_ * stride_ + k_] * R_[k_ * stride_ + k_];
  }

 private:
  Eigen::Index k_;
  int columns_;
  Eigen::Index stride_, rows_;
  double* R_;
  double* A_;
};

SquareRootInformation::SquareRootInformation(std::vector<std::string> columns)
    : columns_(std::move(columns)),
      R_(MatrixXd::Zero(size(), size())),
      z_(VectorXd::Zero(size())) {}

SquareRootInformation::SquareRootInformation(std::vector<std::string> columns, MatrixXd R,
                                             VectorXd z, double rho2, double rows)
    : columns_(std::move(columns)), R_(std::move(R)), z_(std::move(z)), rho2_(rho2), rows_(rows) {
  require(R_.rows() == size() && R_.cols() == size() && z_.size() == size(),
          "SquareRootInformation: R is (", R_.rows(), " x ", R_.cols(), ") and z has ", z_.size(),
          " entries; expected ", size(), " of each.");
  require(R_.isUpperTriangular(0.0) && rho2 >= 0.0 && rows >= 0.0,
          "SquareRootInformation: expected an upper triangular R, and neither rho2 nor rows below "
          "zero.");
}

void SquareRootInformation::absorb(const MatrixRef& A, const VectorRef& b) {
  const int k = size();
  require(A.cols() == k && A.rows() == b.size(), "SquareRootInformation::absorb: A is (", A.rows(),
          " x ", A.cols(), ") and b has ", b.size(), " rows; expected ", k,
          " columns and equal rows.");
  if (A.rows() == 0) return;
  Triangle triangle(*this, std::min(kBlockRows, A.rows()));
  for (Eigen::Index at = 0; at < A.rows(); at += kBlockRows) {
    const Eigen::Index n = std::min(kBlockRows, A.rows() - at);
    for (int j = 0; j < k; ++j) triangle.set_column(j, A.col(j).segment(at, n));
    triangle.set_column(k, b.segment(at, n));
    if (n < kBlockRows) triangle.clear_rows_from(n);
    triangle.update(false);
  }
  triangle.give_to(*this);
  rows_ += static_cast<double>(A.rows());
}

void SquareRootInformation::absorb(const MatrixRef& A, const VectorRef& b, int threads) {
  const auto pieces = static_cast<int>((A.rows() + kPieceRows - 1) / kPieceRows);
  if (pieces < 2 || A.rows() != b.size()) return absorb(A, b);
  std::vector<SquareRootInformation> factors(pieces,
                                             SquareRootInformation(columns_));
  parallel_for(pieces, threads, [&](int p) {
    const Eigen::Index at = p * kPieceRows;
    const Eigen::Index n = std::min(kPieceRows, A.rows() - at);
    factors[p].absorb(A.middleRows(at, n), b.segment(at, n));
  });
  for (size_t step = 1; step < factors.size(); step *= 2) {
    for (size_t p = 0; p + step < factors.size(); p += 2 * step) factors[p].merge(factors[p + step]);
  }
  merge(factors.front());
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
  R_.conservativeResize(k, k);
  z_.conservativeResize(k);
  if (k > before) {
    R_.rightCols(k - before).setZero();
    R_.bottomRows(k - before).setZero();
    z_.tail(k - before).setZero();
  }
  Triangle triangle(*this, m);
  for (int j = 0; j < m; ++j)
    triangle.set_column(place[j], weight * other.R_.col(j).head(j + 1));
  triangle.set_column(k, weight * other.z_);
  // Row i begins at place[i]: the block is triangular only if the columns keep their order.
  triangle.update(std::is_sorted(place.begin(), place.end()));
  triangle.give_to(*this);
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
  MatrixXd A = MatrixXd::Zero(size(), static_cast<Eigen::Index>(columns.size()));
  for (size_t j = 0; j < columns.size(); ++j) {
    const auto found = index.find(columns[j]);
    if (found != index.end()) A.col(static_cast<Eigen::Index>(j)) = R_.col(found->second);
  }
  SquareRootInformation out(columns);
  out.absorb(A, z_);
  out.rho2_ += rho2_;
  out.rows_ = rows_;
  return out;
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
