#pragma once

#include <vector>

#include "diagnosis/evidence/clustered_fit.hpp"
#include "diagnosis/evidence/normal_blocks.hpp"

namespace veridyn {

/// Least squares of a set of columns, factored once for hundreds of evaluations with a few
/// additional columns: by block elimination, without solving for the set again.
class BorderedFit {
 public:
  /// @param sums     rows to fit, minus `without` (if not null). @param measure  rows on which
  /// residuals are measured; null: none.
  BorderedFit(const ColumnSet& set, const VectorXd& weights, const NormalBlocks::Sums& sums,
              const NormalBlocks::Sums* without, const NormalBlocks::Sums* measure);

  /// Squared residual per joint on the rows to measure, of the set alone.
  const VectorXd& residual2() const { return residual2_; }

  struct Border {
    VectorXd values;     ///< Coefficients of the added columns, scaled as the blocks are
    VectorXd residual2;  ///< per joint with them; empty if nothing is to be measured
    double new_share;    ///< largest share of one of their squares that the set does not span
  };
  Border with(const ColumnSet& more) const;

 private:
  MatrixXd weighted(const ColumnSet& rows, const std::vector<OwnColumns>& own_rows,
                    const ColumnSet& columns, const std::vector<OwnColumns>& own_columns) const;
  VectorXd weighted(const ColumnSet& rows) const;

  const ColumnSet& set_;
  const VectorXd weights_;
  const NormalBlocks::Sums& sums_;
  const NormalBlocks::Sums* without_;
  const NormalBlocks::Sums* measure_;
  RidgedSolver solver_;
  VectorXd x_;
  VectorXd residual2_;
  std::vector<OwnColumns> own_;  // per joint
  std::vector<MatrixXd> G_;      // per joint, of the rows to measure, over its own of the set
  std::vector<VectorXd> Gx_;     // G x - g of these rows
};

}  // namespace veridyn
