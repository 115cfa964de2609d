#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "diagnosis/search/score.hpp"
#include "diagnosis/search/terms.hpp"

namespace veridyn::search {

/// A term of the final set.
struct Chosen {
  Term term;
  Columns columns;
  VectorXd ridge;
  std::vector<double> offset;                 ///< value of a linearised term that the arm contains already
  std::optional<Eigen::Vector3d> gravity;     ///< gravity of the corrected arm, for a direction of gravity
  double gain = 0.0, error = 0.0;             ///< gain next to all other terms and its standard error, without the price
  VectorXd of_joint;                          ///< (n) the gain on every joint
  VectorXd values, deviations;                ///< values of its columns; those of a linearised term include its offset
  MatrixXd covariance;                        ///< covariance of its values
  std::vector<double> shape_deviations;       ///< standard deviation of each shape constant; NaN where it is unknown
  VectorXd folds_before, folds_after;         ///< (n) relative held-out error without and with it
  struct RivalTerm {
    Term term;
    double loss = 0.0;  ///< increase of the score with this term in place of the chosen one
    double gain = 0.0;  ///< gain of this term in place of the chosen one
  };
  std::vector<RivalTerm> rivals;
};

/// A tested term that was not chosen.
struct Rejected {
  Term term;
  double gain = 0.0, error = 0.0;
  bool impossible = false;
  bool collinear = false;
};

struct SearchResult {
  std::vector<Chosen> chosen;         ///< terms with names first, in the order of their gain
  std::shared_ptr<const Rows> rows;   ///< rows for the arm with all corrections
  Folds folds;
  MatrixXd residual;                  ///< (rows x n) held out, with all terms
  MatrixXd fitted;                    ///< (rows x n) the same for the fit to all rows
  VectorXd scale;                     ///< (n) scale of the residual
  MatrixXd weights;                   ///< (rows x n) weights of the Student-t loss
  VectorXd values;                    ///< standard parameters of the arm, fitted together with the terms
  /// ((terms + 1) x n) rms residual of the held-out recordings with the first 0, 1, 2, ... terms, fitted to
  /// all training rows; for a MODEL with the base values of the whole set.
  MatrixXd test_error;
  std::shared_ptr<const Rows> test;   ///< rows of the held-out recordings, null if there are none
  MatrixXd test_residual;             ///< (rows x n) with all terms
  /// (n) share of the mean square that curves predict if not all causes are tested; -1: no curve predicts
  /// any. Empty: all causes are tested.
  VectorXd untested_share;
  std::vector<Rejected> rejected;
  int tested_terms = 0;
  int degrees_of_freedom = 1;
};

struct SearchRequest {
  TermScope scope;
  std::vector<std::string> recordings;
  std::vector<double> periods;  ///< [s] of the recordings; 0: no repetition
  PreprocessingOptions preprocessing;
  std::vector<std::string> test;  ///< held-out recordings, on which errors are measured
  PreprocessingOptions test_preprocessing;
  /// Joints without friction in the robot file: the first set contains plain friction there, which is dropped
  /// if superfluous.
  std::set<int> without_friction;
  int most = 20;
  int threads = 0;
  std::function<void(int, int)> progress{};
};

/// Explains the residual of an arm with values on its recordings by terms of one dictionary.
SearchResult search(const Model& arm, const SearchRequest& request);

/// False for a load (m, m c, ...) if the intervals of its mass and of all its determined moments contain
/// zero.
bool is_load(const VectorXd& values, const VectorXd& deviations, double quantile);

/// The arm with the linearised terms of a set applied.
Model corrected(const Model& arm, const std::vector<Chosen>& chosen);

}  // namespace veridyn::search
