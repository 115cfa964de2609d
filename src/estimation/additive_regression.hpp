#pragma once

#include <vector>

#include "estimation/smooth_basis.hpp"

namespace veridyn {

/// A smooth function of one signal, or of two (every product of their functions).
struct SmoothTerm {
  std::vector<int> signals;        ///< one or two columns of the signals
  std::vector<SmoothBasis> bases;  ///< one for each
  /// Its gain counts so much when terms are compared: simpler and nearer ones win ties. In (0, 1].
  double preference = 1.0;

  Eigen::Index size() const;

  /// (rows x size)
  MatrixXd columns(const MatrixXd& signals) const;

  /// Second differences along each signal.
  MatrixXd penalty() const;
};

/// Rows of one regression, in groups that are held out together.
struct FoldedRows {
  MatrixXd signals;          ///< (rows x signals)
  VectorXd response;         ///< (rows)
  std::vector<Eigen::Index> fold_begin;  ///< first row of each fold, and the number of rows
};

struct AdditiveOptions {
  int most_terms = 4;
  double smallest_gain = 0.05;  ///< of a further term: fall of ln(held-out mean square)
  double as_good = 0.9;         ///< share of the best gain from which a term is as good
  double significance = 0.05;   ///< of the signed-rank test over the folds
};

/// What one term of an additive model has, and which others would have done as well in its place.
struct ChosenTerm {
  int term = -1;
  double smoothing = 0.0;
  double gain = 0.0;          ///< when it was taken
  std::vector<int> as_good;   ///< other terms
};

/// y = a_0 + f_1(x) + f_2(x) + ...: the terms that lower the held-out error, taken one at a time
/// until nothing does, the superfluous ones dropped at the end. Smoothing of each by
/// cross-validation. Source: Hastie and Tibshirani, Generalized Additive Models, 1990, chapters 3 and 9.
struct AdditiveModel {
  std::vector<ChosenTerm> chosen;
  double gain = 0.0;           ///< fall of ln(held-out mean square), mean over the folds
  std::vector<double> falls;   ///< the same of each fold
  VectorXd coefficients;       ///< a_0, then those of the chosen terms
  MatrixXd without;            ///< (coefficients x folds) with each fold left out

  /// Part k of the prediction, centred where its columns are centred by `mean_columns` (size of the
  /// term): one value per row of `columns`.
  Eigen::Index first_of(const std::vector<SmoothTerm>& terms, size_t k) const;
};

/// @param columns  of every term at the rows, as SmoothTerm::columns().
AdditiveModel additive_regression(const FoldedRows& rows, const std::vector<SmoothTerm>& terms,
                                  const std::vector<MatrixXd>& columns,
                                  const AdditiveOptions& options);

/// The model of these terms, chosen before.
AdditiveModel additive_fit(const FoldedRows& rows, const std::vector<SmoothTerm>& terms,
                           const std::vector<MatrixXd>& columns, std::vector<ChosenTerm> chosen);

/// The model's value at other rows.
VectorXd predicted(const AdditiveModel& model, const std::vector<SmoothTerm>& terms,
                   const MatrixXd& signals);

}  // namespace veridyn
