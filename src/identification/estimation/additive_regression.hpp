#pragma once

#include <vector>

#include "identification/estimation/estimation_numbers.hpp"
#include "identification/estimation/smooth_basis.hpp"

namespace veridyn {

/// A smooth function of one or more signals: every product of their functions.
struct SmoothTerm {
  std::vector<int> signals;        ///< columns of the signals
  std::vector<SmoothBasis> bases;  ///< one for each
  /// Factor on its gain when terms are compared, in (0, 1], so that simpler and closer terms win
  /// ties.
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
  int most_terms;
  double smallest_gain;  ///< of a further term: decrease of ln(held-out mean square)
  double significance;   ///< of the signed-rank test over the folds
};

/// A chosen term of an additive model.
struct ChosenTerm {
  int term = 0;
  double smoothing = 0.0;
  double gain = 0.0;          ///< when it was chosen
};

/// Y = a_0 + f_1(x) + f_2(x) + ... by forward selection of the terms that lower the held-out error;
/// superfluous ones are dropped at the end. The smoothing of each is chosen by
/// cross-validation. Source: Hastie and Tibshirani, Generalized Additive Models, 1990, chapters 3 and 9.
struct AdditiveModel {
  std::vector<ChosenTerm> chosen;
  double gain = 0.0;           ///< decrease of ln(held-out mean square), mean over the folds
  std::vector<double> falls;   ///< the same for each fold
  VectorXd coefficients;       ///< a_0, then those of the chosen terms

  /// Index of the first coefficient of term k.
  Eigen::Index first_of(const std::vector<SmoothTerm>& terms, size_t k) const;
};

/// @param columns  of every term at the rows, see SmoothTerm::columns().
AdditiveModel additive_regression(const FoldedRows& rows, const std::vector<SmoothTerm>& terms,
                                  const std::vector<MatrixXd>& columns, const AdditiveOptions& options,
                                  const EstimationNumbers& numbers);

/// Fits the model with given terms.
AdditiveModel additive_fit(const FoldedRows& rows, const std::vector<SmoothTerm>& terms,
                           const std::vector<MatrixXd>& columns, std::vector<ChosenTerm> chosen,
                           const EstimationNumbers& numbers);

/// Value of the model at other rows.
VectorXd predicted(const AdditiveModel& model, const std::vector<SmoothTerm>& terms,
                   const MatrixXd& signals);

}  // namespace veridyn
