#pragma once

#include <string>
#include <vector>

#include "veridyn/identification/compressed_recording.hpp"

namespace veridyn {

/// Which columns, by global index.
using ColumnSet = std::vector<int>;

/// Normal equations of every joint and cluster over scaled columns: the form in which hundreds of
/// questions about subsets of columns cost microseconds each. Made from the factors, which keep the
/// accuracy; questions of evidence need no more than half the digits.
class NormalBlocks {
 public:
  /// @param columns  names; every factor's column that is not among them is left away.
  /// @param scale    divisors of the columns, those of the training recordings; empty: the columns'
  /// own norms.
  NormalBlocks(const std::vector<CompressedRecording>& recordings, std::vector<std::string> columns,
               const VectorXd& scale = {});

  int columns() const { return static_cast<int>(names_.size()); }
  int joints() const { return joints_; }
  int clusters() const { return static_cast<int>(clusters_.size()); }
  const std::vector<std::string>& names() const { return names_; }
  int recording_of(int cluster) const { return recording_of_[static_cast<size_t>(cluster)]; }

  /// Norm by which a column was divided; zero where it never acts.
  const VectorXd& scale() const { return scale_; }

  /// What one set of rows says about a set of columns; sums of clusters.
  struct Sums {
    std::vector<MatrixXd> G;  ///< per joint: A'A over all columns
    std::vector<VectorXd> g;  ///< A'b
    VectorXd b2;              ///< b'b per joint
    VectorXd rows;            ///< per joint
  };
  const Sums& total() const { return total_; }
  const Sums& cluster(int c) const { return clusters_[static_cast<size_t>(c)]; }

  /// Least squares of the columns with joint weights; rows are `sums` minus `without` (if not
  /// null).
  VectorXd solve(const ColumnSet& set, const VectorXd& weights, const Sums& sums,
                 const Sums* without) const;

  /// Squared residual per joint of x (over `set`) on the rows of `sums`.
  VectorXd residual2(const ColumnSet& set, const VectorXd& x, const Sums& sums) const;

 private:
  std::vector<std::string> names_;
  int joints_ = 0;
  VectorXd scale_;
  std::vector<Sums> clusters_;
  std::vector<int> recording_of_;
  Sums total_;
};

}  // namespace veridyn
