#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "veridyn/identification/compressed_recording.hpp"

namespace veridyn {

/// Global indices of columns.
using ColumnSet = std::vector<int>;

/// A'A of one joint over the columns that act on it; all others are zero and take no memory.
class JointSquares {
 public:
  /// Local indices of a joint's columns: local_of over all columns (-1: it never acts there).
  struct Places {
    std::vector<int> local_of;
    std::vector<int> column_of;
  };

  explicit JointSquares(std::shared_ptr<const Places> places)
      : places_(std::move(places)),
        values_(MatrixXd::Zero(places_->column_of.size(),
                               static_cast<Eigen::Index>(places_->column_of.size()))) {}

  /// Entry for two columns by their global indices.
  double operator()(int row, int column) const {
    const int r = local(row);
    const int c = local(column);
    return r < 0 || c < 0 ? 0.0 : values_(r, c);
  }

  /// Place of a column among the joint's own, or -1.
  int local(int column) const { return places_->local_of[column]; }
  const std::vector<int>& columns() const { return places_->column_of; }

  /// Entries over the joint's own columns.
  MatrixXd& values() { return values_; }
  const MatrixXd& values() const { return values_; }

  /// Requires the same columns.
  JointSquares& operator+=(const JointSquares& other) {
    values_ += other.values_;
    return *this;
  }

 private:
  std::shared_ptr<const Places> places_;
  MatrixXd values_;
};

/// Columns of a set that act on one joint: their indices in the set, and in the joint.
struct OwnColumns {
  OwnColumns(const ColumnSet& set, const JointSquares& of);
  Eigen::Index size() const { return static_cast<Eigen::Index>(in_set.size()); }

  std::vector<Eigen::Index> in_set, in_joint;
};

/// Normal equations of every joint and cluster over scaled columns: evaluating a subset of columns
/// costs microseconds. Computed from the factors, which keep the accuracy; tests need no more than
/// half the digits.
class NormalBlocks {
 public:
  /// @param columns  names; other columns of the factors are dropped. @param scale    divisors of
  /// the columns, those of the training recordings; empty: the columns' own norms.
  NormalBlocks(const std::vector<CompressedRecording>& recordings, std::vector<std::string> columns,
               const VectorXd& scale = {});

  /// The same, and every factor is emptied once it has been entered, because both together would
  /// take twice the memory. Other facts of the recordings are kept.
  struct EmptiedFactors {};
  NormalBlocks(std::vector<CompressedRecording>& recordings, std::vector<std::string> columns,
               EmptiedFactors);

  int columns() const { return static_cast<int>(names_.size()); }
  int joints() const { return joints_; }
  int clusters() const { return static_cast<int>(clusters_.size()); }
  const std::vector<std::string>& names() const { return names_; }
  int recording_of(int cluster) const { return recording_of_[cluster]; }

  /// Norm by which a column was divided; zero where it never acts.
  const VectorXd& scale() const { return scale_; }

  /// Normal equations of one set of rows; sums of clusters.
  struct Sums {
    std::vector<JointSquares> G;  ///< per joint: A'A
    std::vector<VectorXd> g;      ///< A'b over all columns
    VectorXd b2;                  ///< b'b per joint
    VectorXd rows;                ///< per joint
  };
  const Sums& total() const { return total_; }
  const Sums& cluster(int c) const { return clusters_[c]; }

  /// Least squares of the columns with joint weights; rows are `sums` minus `without` (if not
  /// null). @param prior  precisions of a normal prior with mean zero over the set's scaled columns; empty: none.
  VectorXd solve(const ColumnSet& set, const VectorXd& weights, const Sums& sums,
                 const Sums* without, const VectorXd& prior = {}) const;

  /// Squared residual per joint of x (over `set`) on the rows of `sums`.
  VectorXd residual2(const ColumnSet& set, const VectorXd& x, const Sums& sums) const;

 private:
  NormalBlocks(const std::vector<CompressedRecording>& recordings, std::vector<std::string> columns,
               const VectorXd& scale, std::vector<CompressedRecording>* emptied);

  std::vector<std::string> names_;
  int joints_ = 0;
  VectorXd scale_;
  std::vector<Sums> clusters_;
  std::vector<int> recording_of_;
  Sums total_;
};

}  // namespace veridyn
