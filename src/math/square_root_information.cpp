#include "veridyn/math/square_root_information.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
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

Eigen::Index packed_size(Eigen::Index columns) {
  return columns * (columns + 1) / 2;
}

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
    const double* next = of.R_.data();
    for (Eigen::Index j = 0; j < k_; ++j)
      for (Eigen::Index i = 0; i <= j; ++i) R_[i * stride_ + j] = *next++;
    for (Eigen::Index i = 0; i < k_; ++i) R_[i * stride_ + k_] = of.z_[i];
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
    double* next = to.R_.data();
    for (Eigen::Index j = 0; j < k_; ++j)
      for (Eigen::Index i = 0; i <= j; ++i) *next++ = R_[i * stride_ + j];
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

const SquareRootInformation::Names& SquareRootInformation::no_names() {
  static const Names none = std::make_shared<const std::vector<std::string>>();
  return none;
}

SquareRootInformation::SquareRootInformation(std::vector<std::string> columns)
    : columns_(std::make_shared<const std::vector<std::string>>(std::move(columns))),
      R_(VectorXd::Zero(packed_size(size()))),
      z_(VectorXd::Zero(size())) {}

SquareRootInformation::SquareRootInformation(std::vector<std::string> columns, MatrixXd R,
                                             VectorXd z, double rho2, double rows)
    : SquareRootInformation(std::move(columns)) {
  require(R.rows() == size() && R.cols() == size() && z.size() == size(),
          "SquareRootInformation: R is (", R.rows(), " x ", R.cols(), ") and z has ", z.size(),
          " entries; expected ", size(), " of each.");
  require(R.isUpperTriangular(0.0) && rho2 >= 0.0 && rows >= 0.0,
          "SquareRootInformation: expected an upper triangular R, and neither rho2 nor rows below "
          "zero.");
  for (Eigen::Index j = 0; j < R.cols(); ++j) R_.segment(j * (j + 1) / 2, j + 1) = R.col(j).head(j + 1);
  z_ = std::move(z);
  rho2_ = rho2;
  rows_ = rows;
}

MatrixXd SquareRootInformation::R() const {
  MatrixXd out = MatrixXd::Zero(size(), size());
  for (Eigen::Index j = 0; j < out.cols(); ++j) out.col(j).head(j + 1) = packed(j);
  return out;
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
  std::vector<SquareRootInformation> factors(pieces, SquareRootInformation(columns()));
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
  const int m = other.size();
  std::vector<int> place(static_cast<size_t>(m));
  if (columns_ == other.columns_ || columns() == other.columns()) {
    std::iota(place.begin(), place.end(), 0);
  } else {
    std::unordered_map<std::string, int> index;
    for (int i = 0; i < size(); ++i) index.emplace(columns()[i], i);
    std::vector<std::string> all = columns();
    for (int j = 0; j < m; ++j) {
      const auto found = index.find(other.columns()[j]);
      place[j] = found != index.end() ? found->second : static_cast<int>(all.size());
      if (found == index.end()) all.push_back(other.columns()[j]);
    }
    if (static_cast<int>(all.size()) > size()) {
      SquareRootInformation wider(std::move(all));
      wider.R_.head(R_.size()) = R_;
      wider.z_.head(z_.size()) = z_;
      wider.rho2_ = rho2_;
      wider.rows_ = rows_;
      *this = std::move(wider);
    }
  }
  const int k = size();
  Triangle triangle(*this, m);
  for (int j = 0; j < m; ++j)
    triangle.set_column(place[j], weight * other.packed(j));
  triangle.set_column(k, weight * other.z_);
  // Row i begins at place[i]: the block is triangular only if the columns keep their order.
  triangle.update(std::is_sorted(place.begin(), place.end()));
  triangle.give_to(*this);
  rho2_ += weight * weight * other.rho2_;
  rows_ += other.rows_;
}

double SquareRootInformation::residual2(const VectorRef& x) const {
  VectorXd error = -z_;
  for (Eigen::Index j = 0; j < size(); ++j) error.head(j + 1) += x[j] * packed(j);
  return error.squaredNorm() + rho2_;
}

SquareRootInformation SquareRootInformation::restricted(
    const std::vector<std::string>& columns) const {
  std::unordered_map<std::string, int> index;
  for (int i = 0; i < size(); ++i) index.emplace(this->columns()[i], i);
  MatrixXd A = MatrixXd::Zero(size(), static_cast<Eigen::Index>(columns.size()));
  for (size_t j = 0; j < columns.size(); ++j) {
    const auto found = index.find(columns[j]);
    if (found == index.end()) continue;
    A.col(static_cast<Eigen::Index>(j)).head(found->second + 1) = packed(found->second);
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
  out.absorb(R().triangularView<Eigen::Upper>() * T, z_);
  out.rho2_ += rho2_;
  out.rows_ = rows_;
  return out;
}

VectorXd SquareRootInformation::column_norms() const {
  VectorXd norms(size());
  for (Eigen::Index j = 0; j < norms.size(); ++j) norms[j] = packed(j).norm();
  return norms;
}

}  // namespace veridyn
