#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>

#include "diagnosis/search/base.hpp"

namespace veridyn::search {

/// A chosen term as a round needs it: its columns, ridge and nonnegative levels.
struct SetTerm {
  const Columns* columns;
  VectorXd ridge;
  std::vector<Level> nonnegative;
};

/// A fitted set of terms with its held-out errors.
struct Fitted {
  MatrixXd residual;  ///< (rows x n) held out, in order of time; empty for a set with a further term
  VectorXd scale;     ///< (n) scale of the Student-t loss
  MatrixXd loss;      ///< (blocks x n) sum of the loss over the rows of every block
  double score = 0.0; ///< score without the prices of terms
  VectorXd x;         ///< coefficients from all rows: directions of the base, then every chosen term, then the further one
  double prior = 0.0; ///< part of the score that comes from the MODEL's prior
};

/// Gram matrices of one further term and the terms of a round.
struct Cross {
  const Columns* columns = nullptr;
  VectorXd ridge;
  std::vector<MatrixXd> C, D;  ///< per fold
  std::vector<VectorXd> d;
};

/// Base and some of the chosen terms, factored on the rows outside of each fold and on all rows. Solutions
/// ignore the bounds.
struct Subset {
  std::vector<int> columns;
  std::vector<Eigen::LLT<MatrixXd>> fold;
  std::unique_ptr<Eigen::LLT<MatrixXd>> all;
  std::vector<VectorXd> x_fold;
  VectorXd x;
};

/// Gain of one set over another, and its standard error over blocks.
struct Gain {
  double sum = 0.0, error = 0.0, limit = 0.0;  ///< gain, its standard error, and limit = errors * standard error
  VectorXd of_joint, error_of_joint;
  double share = 0.0;  ///< largest relative decrease of a joint's mean square
  VectorXd rise;       ///< (n) relative increase of every joint's mean square
  double prior = 0.0;  ///< part of the sum that comes from the MODEL's prior
};

/// Gain on rows to which no set was fitted.
/// @param with, without  (rows x n) residuals of both sets.
/// @param weight  (n) independent samples of a row.
Gain gain_on(const Rows& rows, const MatrixXd& with, const MatrixXd& without, const VectorXd& weight);

/// Quantities that stay fixed while terms are added, polished and exchanged: weights of the Student-t loss,
/// and scale and number of independent samples of every joint, computed from the current set.
class Round {
 public:
  /// @param weights  (rows x n) weights of the previous round, or empty; they are updated.
  Round(const Rows& rows, const Folds& folds, const Base& base, const std::vector<SetTerm>& chosen, MatrixXd& weights);

  const VectorXd& scale() const { return scale_; }
  const VectorXd& samples() const { return samples_; }
  /// (n) independent samples for one row.
  VectorXd samples_of_row() const { return samples_.cwiseQuotient(rows_of_.cwiseMax(1.0)); }
  const MatrixXd& weights() const { return weights_; }

  /// The base with all chosen terms, and the fit of both.
  const Subset& whole() const { return whole_; }
  const Fitted& fit() const { return fit_; }
  Subset subset(const std::vector<int>& chosen) const;  ///< @param chosen  indices of chosen terms
  Cross cross(const Columns& columns, const VectorXd& ridge) const;  ///< products of a further term's columns

  /// A and b of the weighted squares z' A z - 2 b' z that further columns with coefficients z add to those of a subset
  /// which is fitted at the same time.
  std::pair<MatrixXd, VectorXd> normal_equations(const Subset& s, const Cross& c) const;

  /// Upper bound of the gain of a term: the decrease of the weighted squares on the fitted rows.
  double training_gain(const Subset& s, const Cross& c) const;
  Fitted evaluate(const Subset& s, const Cross* c = nullptr) const;  ///< fit of s, and of a further term if c is not null

  Gain gain(const Fitted& with, const Fitted& without) const;  ///< the fit `with` against the fit `without`, prior included

  /// Covariance of the values of a fit, from the scatter of its blocks.
  /// @param M  combinations of the coefficients, one a row.
  MatrixXd covariance(const Subset& s, const Fitted& fit, const MatrixXd& M) const;

 private:
  struct Bordered;
  void within_bounds(const Subset& s, const Eigen::LLT<MatrixXd>& factor, const Bordered* border, VectorXd& x, VectorXd& z) const;  ///< also moves z, the coefficients of `border`, if there is one
  void solve(const std::vector<int>& columns, const MatrixXd& G_of_rows, const VectorXd& g, Eigen::LLT<MatrixXd>& factor, VectorXd& x) const;
  Subset on_all_rows(const std::vector<int>& chosen) const;  ///< without the factors of the folds
  double score_of(const Fitted& fit) const;
  void update_weights(const MatrixXd& residual);  ///< updates weights_, scale_ and samples_
  void compute_gram_matrices();  ///< computes the Gram matrices of all folds

  const Rows& rows_;
  const Folds& folds_;
  Eigen::Index base_ = 0;
  bool prior_ = false;
  std::vector<Eigen::Index> order_, begin_;  // rows sorted by fold; first sorted row of every fold, then the number of rows
  std::vector<int> block_;                   // block of every row, in the order of order_
  std::vector<std::vector<int>> acting_;     // for each joint, the columns with a torque on it
  std::vector<MatrixXd> X_;                  // for each joint, these columns in the order of order_
  std::vector<std::pair<Eigen::Index, Eigen::Index>> ranges_;  // first column and number of columns of every chosen term
  MatrixXd y_, used_, a_, weights_;          // rows in the order of order_
  MatrixXd bounds_;    // (bounds x columns): value + row . x >= 0
  VectorXd value_;
  VectorXd ridge_, scale_, samples_, rows_of_, floor_;
  std::vector<MatrixXd> G_;
  std::vector<VectorXd> g_;
  MatrixXd G_all_;
  VectorXd g_all_;
  Subset whole_;
  Fitted fit_;
};

}  // namespace veridyn::search
