#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Cholesky>

#include "diagnosis/search/base.hpp"

namespace veridyn::search {

/// A term of a set.
struct SetTerm {
  const Columns* columns;
  VectorXd ridge;
  std::vector<Level> nonnegative;
};

/// A set of terms with its held-out residual.
struct Fitted {
  MatrixXd residual;  ///< (rows x n) held out, in order of time
  VectorXd scale;     ///< (n) of the Student-t loss
  VectorXd loss;      ///< (n) its mean over the rows
  double score = 0.0; ///< without the prices of terms
  VectorXd x;         ///< from all rows: directions of the base, then every chosen term, then the further one
  double prior = 0.0;
};

/// The Gram matrices of one further term with those of a round.
struct Cross {
  const Columns* columns = nullptr;
  VectorXd ridge;
  std::vector<MatrixXd> C, D;  ///< per fold
  std::vector<VectorXd> d;
};

/// Base and some of the chosen terms, factored on the rows outside of every fold and on all. Solutions are those without
/// bounds.
struct Subset {
  std::vector<int> columns;
  std::vector<Eigen::LLT<MatrixXd>> fold;
  std::unique_ptr<Eigen::LLT<MatrixXd>> all;
  std::vector<VectorXd> x_fold;
  VectorXd x;
};

/// Gain of one set over another, and its standard error over blocks.
struct Gain {
  double sum = 0.0, error = 0.0, limit = 0.0;  ///< limit: errors * standard error
  VectorXd of_joint, error_of_joint;
  double share = 0.0;  ///< largest fall of a joint's mean square
  VectorXd rise;       ///< (n) of every joint's mean square, as a share of it
  double prior = 0.0;  ///< part of the sum that a MODEL's prior no longer pays
};

/// The same on rows that no set was fitted to.
/// @param weight  (n) independent samples of a row.
Gain gain_on(const Rows& rows, const MatrixXd& with, const MatrixXd& without, const VectorXd& weight);

/// What stays fixed while terms are added, polished and exchanged: the weights of the Student-t loss, the scale and the
/// number of independent samples of every joint, from the present set.
class Round {
 public:
  /// @param weights  (rows x n) of the round before, or empty; replaced.
  Round(const Rows& rows, const Folds& folds, const Base& base, const std::vector<SetTerm>& chosen, MatrixXd& weights);

  const VectorXd& scale() const { return scale_; }
  const VectorXd& samples() const { return samples_; }
  /// (n) independent samples of one row.
  VectorXd samples_of_row() const { return samples_.cwiseQuotient(rows_of_.cwiseMax(1.0)); }
  const MatrixXd& weights() const { return weights_; }

  Subset subset(const std::vector<int>& chosen) const;
  Cross cross(const Columns& columns, const VectorXd& ridge) const;

  /// Upper estimate of what a term gains: the fall of the weighted squares on the rows that are fitted.
  double training_gain(const Subset& s, const Cross& c) const;
  Fitted evaluate(const Subset& s, const Cross* c = nullptr) const;

  Gain gain(const Fitted& with, const Fitted& without) const;

  /// Covariance of the values of a fit, from the scatter of its blocks.
  MatrixXd covariance(const Subset& s, const Fitted& fit) const;

 private:
  struct Bordered;
  void within_bounds(const Subset& s, const Eigen::LLT<MatrixXd>& factor, const Bordered* border, VectorXd& x, VectorXd& z) const;
  void weigh(const MatrixXd& residual);
  void gram();
  VectorXd losses(const MatrixXd& residual, VectorXd& scale) const;

  const Rows& rows_;
  const Folds& folds_;
  Eigen::Index base_ = 0;
  bool prior_ = false;
  std::vector<Eigen::Index> order_, begin_;  // rows sorted by fold; first of every fold, and their number
  std::vector<std::vector<int>> acting_;     // per joint, the columns that have a torque on it
  std::vector<MatrixXd> X_;                  // per joint, these columns, rows sorted
  std::vector<std::pair<Eigen::Index, Eigen::Index>> ranges_;  // of every chosen term
  MatrixXd y_, used_, a_, weights_;          // sorted
  MatrixXd bounds_;    // (bounds x columns): value + row . x >= 0
  VectorXd value_;
  VectorXd ridge_, scale_, samples_, rows_of_, floor_;
  std::vector<MatrixXd> G_;
  std::vector<VectorXd> g_;
  MatrixXd G_all_;
  VectorXd g_all_;
};

}  // namespace veridyn::search
