#pragma once

#include <memory>
#include <string>
#include <vector>

#include "veridyn/math/types.hpp"

namespace veridyn {

/// Least-squares information of any number of rows A x ~ b, in memory that depends on the number of
/// columns alone:
///
///   || A x - b ||^2  =  || R x - z ||^2 + rho^2
///
/// R is upper triangular (k x k). Rows are absorbed in blocks by QR; factors over the same columns
/// merge by one more QR, in any order. Columns have names, so that a subset can be solved without a
/// copy of the data; copies share the names. R is stored as a packed triangle. Source: Bierman,
/// Factorization Methods for Discrete Sequential Estimation, 1977.
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

  /// (size() x size()), made from the packed triangle at every call.
  MatrixXd R() const;
  const VectorXd& z() const { return z_; }

  /// Squared residual that no x can remove.
  double rho2() const { return rho2_; }

  /// Rows absorbed so far.
  double rows() const { return rows_; }

  /// || b ||^2 of all rows.
  double rhs_norm2() const { return z_.squaredNorm() + rho2_; }

  /// Adds the rows of A x ~ b; A is (rows x size()). Householder reflections in panels (compact
  /// WY) on blocks that stay in the cache, 2 rows size()^2 operations; nothing is allocated after
  /// a thread's first call of a size.
  void absorb(const MatrixRef& A, const VectorRef& b);

  /// The same on several threads. The rows are cut into pieces whose factors are merged in a fixed
  /// tree, so that the result does not depend on the number of threads.
  /// @param threads  0: one per core.
  void absorb(const MatrixRef& A, const VectorRef& b, int threads);

  /// Adds the rows of another factor, each scaled by `weight`. Columns that only the other one has
  /// are appended.
  void merge(const SquareRootInformation& other, double weight = 1.0);

  /// || A x - b ||^2 for x in the order of columns().
  double residual2(const VectorRef& x) const;

  /// The same rows restricted to these columns, in this order. A column that the factor does not
  /// have is zero.
  SquareRootInformation restricted(const std::vector<std::string>& columns) const;

  /// The same rows after a change of variables x = T y: columns are named anew. T is (size() x new
  /// size).
  SquareRootInformation transformed(const MatrixRef& T, std::vector<std::string> columns) const;

  /// The norm of every column of A, (size()).
  VectorXd column_norms() const;

 private:
  class Triangle;

  using Names = std::shared_ptr<const std::vector<std::string>>;
  static const Names& no_names();
  auto packed(Eigen::Index j) const { return R_.segment(j * (j + 1) / 2, j + 1); }

  Names columns_ = no_names();
  VectorXd R_;  // column by column down to the diagonal
  VectorXd z_;
  double rho2_ = 0.0;
  double rows_ = 0.0;
};

}  // namespace veridyn
