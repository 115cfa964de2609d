#pragma once

#include <memory>
#include <string>
#include <vector>

#include "veridyn/math/types.hpp"

namespace veridyn {

/// Least-squares information of any number of rows A x ~ b, in memory that depends on the number of columns alone:
///
///   || A x - b ||^2  =  || R x - z ||^2 + rho^2
///
/// R is upper triangular (k x k). Rows are absorbed in blocks by QR; factors over the same columns
/// merge by one more QR, in any order. Columns have names, so that a subset can be solved without a
/// copy of the data; copies share the names. With many columns, up to half as many rows are stored
/// unfactored, which needs less memory than a triangle; R, z and rho are then computed at every call. Source:
/// Bierman, Factorization Methods for Discrete Sequential Estimation, 1977.
class SquareRootInformation {
 public:
  SquareRootInformation() = default;
  explicit SquareRootInformation(std::vector<std::string> columns);

  /// Builds a factor from its parts, such as those read from a file.
  /// @throws InvalidInput  the sizes differ, R is not upper triangular, or rho2 or rows are
  /// negative.
  SquareRootInformation(std::vector<std::string> columns, MatrixXd R, VectorXd z, double rho2,
                        double rows);

  const std::vector<std::string>& columns() const { return *columns_; }
  int size() const { return static_cast<int>(columns_->size()); }

  /// The triangle R, (size() x size()), computed at every call.
  MatrixXd R() const;
  VectorXd z() const;

  /// The squared residual rho^2 that no x can remove.
  double rho2() const;

  /// Number of rows absorbed so far.
  double rows() const { return rows_; }

  /// The sum || b ||^2 over all rows.
  double rhs_norm2() const { return z_.squaredNorm() + rho2_; }

  /// Adds the rows of A x ~ b; A is (rows x size()). Householder reflections in panels (compact
  /// WY) on blocks that stay in the cache, 2 rows size()^2 operations; nothing is allocated after
  /// a thread's first call of a size.
  void absorb(const MatrixRef& A, const VectorRef& b);

  /// Adds the rows of another factor, each scaled by `weight`. Columns that only the other one has are appended.
  void merge(const SquareRootInformation& other, double weight = 1.0);

  /// Like merge(), but columns that this factor does not have are ignored.
  void merge_known(const SquareRootInformation& other, double weight = 1.0);

  /// The squared residual || A x - b ||^2 for x in the order of columns().
  double residual2(const VectorRef& x) const;

  /// A factor of these rows restricted to the given columns, in their order. A column that the factor does not
  /// have is zero.
  SquareRootInformation restricted(const std::vector<std::string>& columns) const;

  /// A factor of these rows after a change of variables x = T y: columns are named anew. T is (size() x new
  /// size).
  SquareRootInformation transformed(const MatrixRef& T, std::vector<std::string> columns) const;

  /// The norm of every column of A, (size()).
  VectorXd column_norms() const;

 private:
  class Triangle;

  using Names = std::shared_ptr<const std::vector<std::string>>;
  static const Names& no_names();
  bool is_triangle() const { return z_.size() == size(); }  ///< true: data_ is a factor R, else unfactored rows
  bool may_defer_factorization(Eigen::Index more) const;
  SquareRootInformation as_triangle() const;  ///< the same information, factored
  void resize(Eigen::Index rows);
  Eigen::Index stored_rows() const { return z_.size(); }
  Eigen::Index begin_of_row(Eigen::Index i) const { return i * size() - (is_triangle() ? i * (i - 1) / 2 : 0); }  ///< in data_
  Eigen::Index length_of_row(Eigen::Index i) const { return size() - (is_triangle() ? i : 0); }
  auto row(Eigen::Index i) { return data_.segment(begin_of_row(i), length_of_row(i)); }
  auto row(Eigen::Index i) const { return data_.segment(begin_of_row(i), length_of_row(i)); }
  std::vector<int> column_indices_of(const SquareRootInformation& other) const;

  Names columns_ = no_names();
  Eigen::RowVectorXd data_;  // row by row: all columns of unfactored rows; of a triangle the columns from the diagonal on
  VectorXd z_;               // right-hand sides of those rows
  double rho2_ = 0.0;
  double rows_ = 0.0;
};

}  // namespace veridyn
