#include "veridyn/math/square_root_information.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "aligned_doubles.hpp"
#include "triangle_update.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr Eigen::Index kBlockRows = 256;  // number of rows of a block: with 60 columns half of a 256 KiB cache
// Number of columns from which on a factor stores its first rows without factoring them. Smaller triangles need
// little memory; they are factored at once, and are equal to the last bit after being stored in a file.
constexpr int kManyColumns = 128;

}  // namespace

// The factor [R z; 0 rho] in the layout of the kernels, and a block of rows below it.
class SquareRootInformation::Triangle {
 public:
  Triangle(const SquareRootInformation& of, Eigen::Index rows)
      : k_(of.size()),
        columns_(triangle_columns(static_cast<int>(k_) + 1)),
        stride_(triangle_stride(static_cast<int>(k_) + 1)) {
    const Eigen::Index open = of.is_triangle() ? 0 : of.stored_rows();
    rows_ = (std::max(rows, open) + kTriangleRows - 1) / kTriangleRows * kTriangleRows;
    thread_local AlignedDoubles memory;
    const auto top = static_cast<size_t>(columns_ * stride_);
    R_ = memory.zeros(top + static_cast<size_t>(rows_ * stride_));
    A_ = R_ + top;
    R_[k_ * stride_ + k_] = std::sqrt(of.rho2_);
    double* const to = open > 0 ? A_ : R_;
    for (Eigen::Index i = 0; i < of.stored_rows(); ++i) {
      const auto row = of.row(i);
      std::copy_n(row.data(), row.size(), to + i * stride_ + k_ - row.size());
      to[i * stride_ + k_] = of.z_[i];
    }
    if (open == 0) return;
    update(open, [](Eigen::Index) { return 0; });
    clear_rows_from(0);
  }

  double* row(Eigen::Index i) { return A_ + i * stride_; }

  void clear_rows_from(Eigen::Index first) {
    std::fill(A_ + first * stride_, A_ + rows_ * stride_, 0.0);
  }

  // Writes column j of the block's first rows.
  template <typename Column>
  void set_column(Eigen::Index j, const Column& values) {
    double* to = A_ + j;
    for (Eigen::Index i = 0; i < values.size(); ++i) to[i * stride_] = values[i];
  }

  // Rotates the first rows of the block into the triangle. begin(i) is the first column of row i that may
  // differ from zero; it must not decrease with i.
  template <typename Begin>
  void update(Eigen::Index rows, const Begin& begin) {
    thread_local std::vector<int> begun;
    begun.resize(static_cast<size_t>(columns_ / kTrianglePanel));
    Eigen::Index i = 0;
    for (size_t p = 0; p < begun.size(); ++p) {
      while (i < rows && begin(i) < static_cast<int>(p + 1) * kTrianglePanel) ++i;
      begun[p] = static_cast<int>((i + kTriangleRows - 1) / kTriangleRows * kTriangleRows);
    }
    triangle_kernels().update({R_, A_, stride_, columns_, begun.data()});
  }

  // Copies R, z and rho^2 into `to`, which becomes a triangle.
  void move_rows_to(SquareRootInformation& to) const {
    to.resize(k_);
    for (Eigen::Index i = 0; i < k_; ++i) {
      std::copy_n(R_ + i * stride_ + i, k_ - i, to.row(i).data());
      to.z_[i] = R_[i * stride_ + k_];
    }
    to.rho2_ = R_[k_ * stride_ + k_] * R_[k_ * stride_ + k_];
  }

 private:
  Eigen::Index k_;
  int columns_;
  Eigen::Index stride_;
  Eigen::Index rows_ = 0;
  double* R_ = nullptr;
  double* A_ = nullptr;
};

const SquareRootInformation::Names& SquareRootInformation::no_names() {
  static const Names none = std::make_shared<const std::vector<std::string>>();
  return none;
}

SquareRootInformation::SquareRootInformation(std::vector<std::string> columns)
    : columns_(std::make_shared<const std::vector<std::string>>(std::move(columns))) {}

SquareRootInformation::SquareRootInformation(std::vector<std::string> columns, MatrixXd R,
                                             VectorXd z, double rho2, double rows)
    : SquareRootInformation(std::move(columns)) {
  require(R.rows() == size() && R.cols() == size() && z.size() == size(),
          "SquareRootInformation: R is (", R.rows(), " x ", R.cols(), ") and z has ", z.size(),
          " entries; expected ", size(), " of each.");
  require(R.isUpperTriangular(0.0) && rho2 >= 0.0 && rows >= 0.0,
          "SquareRootInformation: expected an upper triangular R, and neither rho2 nor rows below "
          "zero.");
  resize(size());
  for (Eigen::Index i = 0; i < R.rows(); ++i) row(i) = R.row(i).tail(row(i).size());
  z_ = std::move(z);
  rho2_ = rho2;
  rows_ = rows;
}

// True if this many more rows may be stored unfactored.
bool SquareRootInformation::may_defer_factorization(Eigen::Index more) const {
  return !is_triangle() && size() >= kManyColumns && 2 * (stored_rows() + more) <= size();
}

// Allocates this number of rows: size() of them form a triangle. Rows that are stored unfactored are kept; a
// triangle is not.
void SquareRootInformation::resize(Eigen::Index rows) {
  data_.conservativeResize(rows < size() ? rows * size() : size() * (size() + 1L) / 2);
  z_.conservativeResize(rows);
}

SquareRootInformation SquareRootInformation::as_triangle() const {
  SquareRootInformation out(*this);
  if (!is_triangle()) Triangle(*this, 0).move_rows_to(out);
  return out;
}

MatrixXd SquareRootInformation::R() const {
  if (!is_triangle()) return as_triangle().R();
  MatrixXd out = MatrixXd::Zero(size(), size());
  for (Eigen::Index i = 0; i < size(); ++i) out.row(i).tail(row(i).size()) = row(i);
  return out;
}

VectorXd SquareRootInformation::z() const { return is_triangle() ? z_ : as_triangle().z_; }

double SquareRootInformation::rho2() const { return is_triangle() ? rho2_ : as_triangle().rho2_; }

void SquareRootInformation::absorb(const MatrixRef& A, const VectorRef& b) {
  const int k = size();
  require(A.cols() == k && A.rows() == b.size(), "SquareRootInformation::absorb: A is (", A.rows(),
          " x ", A.cols(), ") and b has ", b.size(), " rows; expected ", k,
          " columns and equal rows.");
  if (A.rows() == 0) return;
  rows_ += static_cast<double>(A.rows());
  if (may_defer_factorization(A.rows())) {
    const Eigen::Index before = stored_rows();
    resize(before + A.rows());
    for (Eigen::Index i = 0; i < A.rows(); ++i) row(before + i) = A.row(i);
    z_.tail(b.size()) = b;
    return;
  }
  Triangle triangle(*this, std::min(kBlockRows, A.rows()));
  for (Eigen::Index at = 0; at < A.rows(); at += kBlockRows) {
    const Eigen::Index n = std::min(kBlockRows, A.rows() - at);
    for (int j = 0; j < k; ++j) triangle.set_column(j, A.col(j).segment(at, n));
    triangle.set_column(k, b.segment(at, n));
    triangle.clear_rows_from(n);
    triangle.update(n, [](Eigen::Index) { return 0; });
  }
  triangle.move_rows_to(*this);
}

void SquareRootInformation::merge(const SquareRootInformation& other, double weight) {
  const std::vector<int> place = column_indices_of(other);
  if (std::count(place.begin(), place.end(), -1) > 0) {
    std::vector<std::string> all = columns();
    for (size_t j = 0; j < place.size(); ++j)
      if (place[j] < 0) all.push_back(other.columns()[j]);
    SquareRootInformation wider(std::move(all));
    wider.merge_known(*this);
    *this = std::move(wider);
  }
  merge_known(other, weight);
}

// Index in this factor of every column of another one; -1 if this one does not have it.
std::vector<int> SquareRootInformation::column_indices_of(const SquareRootInformation& other) const {
  std::vector<int> place(static_cast<size_t>(other.size()), -1);
  if (columns_ == other.columns_ || columns() == other.columns()) {
    std::iota(place.begin(), place.end(), 0);
    return place;
  }
  std::unordered_map<std::string_view, int> index;
  for (int i = 0; i < size(); ++i) index.emplace(columns()[i], i);
  for (size_t j = 0; j < place.size(); ++j) {
    const auto found = index.find(other.columns()[j]);
    if (found != index.end()) place[j] = found->second;
  }
  return place;
}

void SquareRootInformation::merge_known(const SquareRootInformation& other, double weight) {
  const std::vector<int> place = column_indices_of(other);  // indices of its columns in this factor
  const Eigen::Index count = other.stored_rows();
  rows_ += other.rows_;
  rho2_ += weight * weight * other.rho2_;
  if (count == 0) return;
  // Copies row i to a row of this factor that begins at `to`.
  const auto fill = [&](Eigen::Index i, double* to) {
    const auto from = other.row(i);
    const size_t first = place.size() - static_cast<size_t>(from.size());
    for (size_t j = first; j < place.size(); ++j)
      if (place[j] >= 0) to[place[j]] = weight * from[static_cast<Eigen::Index>(j - first)];
  };
  if (!other.is_triangle() && may_defer_factorization(count)) {
    const Eigen::Index before = stored_rows();
    resize(before + count);
    data_.tail(count * size()).setZero();
    for (Eigen::Index i = 0; i < count; ++i) fill(i, row(before + i).data());
    z_.tail(count) = weight * other.z_.head(count);  // other may be *this
    return;
  }
  // Row i begins at its first column that this factor has: in a triangle these do not decrease.
  std::vector<int> begin(place.size() + 1, size());
  for (size_t j = place.size(); j-- > 0;) begin[j] = place[j] < 0 ? begin[j + 1] : std::min(begin[j + 1], place[j]);
  const double more = rho2_;
  rho2_ = 0.0;
  Triangle triangle(*this, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    fill(i, triangle.row(i));
    triangle.row(i)[size()] = weight * other.z_[i];
  }
  triangle.update(count, [&](Eigen::Index i) { return begin[place.size() - static_cast<size_t>(other.row(i).size())]; });
  triangle.move_rows_to(*this);
  rho2_ += more;
}

double SquareRootInformation::residual2(const VectorRef& x) const {
  double sum = rho2_;
  for (Eigen::Index i = 0; i < stored_rows(); ++i)
    sum += std::pow(row(i).dot(x.tail(row(i).size())) - z_[i], 2);
  return sum;
}

SquareRootInformation SquareRootInformation::restricted(
    const std::vector<std::string>& columns) const {
  SquareRootInformation out(columns);
  out.merge_known(*this);
  return out;
}

SquareRootInformation SquareRootInformation::transformed(const MatrixRef& T,
                                                         std::vector<std::string> columns) const {
  if (!is_triangle()) return as_triangle().transformed(T, std::move(columns));
  SquareRootInformation out(std::move(columns));
  out.absorb(R().triangularView<Eigen::Upper>() * T, z_);
  out.rho2_ += rho2_;
  out.rows_ = rows_;
  return out;
}

VectorXd SquareRootInformation::column_norms() const {
  VectorXd squares = VectorXd::Zero(size());
  for (Eigen::Index i = 0; i < stored_rows(); ++i) squares.tail(row(i).size()) += row(i).cwiseAbs2().transpose();
  return squares.cwiseSqrt();
}

}  // namespace veridyn
