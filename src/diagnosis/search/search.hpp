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
  std::vector<double> offset;                 ///< of a linearised term: its present value in the arm
  std::optional<Eigen::Vector3d> gravity;     ///< of a direction of gravity: the arm's present one
  double gain = 0.0, error = 0.0;             ///< beside all others, without its price
  VectorXd of_joint;                          ///< (n) the same of every joint
  VectorXd values, deviations;                ///< of its columns; of a linearised term with its offset
  MatrixXd covariance;                        ///< of its columns
  std::vector<double> shape_deviations;       ///< of each shape; NaN where it is not known
  VectorXd folds_before, folds_after;         ///< (n) relative error held out, without and with it
  struct RivalTerm {
    Term term;
    double loss = 0.0;  ///< by how much the score is worse with it in place
    double gain = 0.0;  ///< of it in place
  };
  std::vector<RivalTerm> rivals;
};

/// A tested term that was not chosen.
struct Refused {
  Term term;
  double gain = 0.0, error = 0.0;
  bool impossible = false;
  bool collinear = false;
};

struct SearchResult {
  std::vector<Chosen> chosen;         ///< those with names first, in the order of their gain
  std::shared_ptr<const Rows> rows;   ///< at the arm with all corrections
  Folds folds;
  MatrixXd residual;                  ///< (rows x n) held out, with all terms
  MatrixXd fitted;                    ///< (rows x n) the same of the fit to all rows
  VectorXd scale;                     ///< (n) of the residual
  MatrixXd weights;                   ///< (rows x n) of the Student-t loss
  VectorXd values;                    ///< standard parameters of the arm beside the terms
  /// (terms + 1) x n: rms of what the first so many terms leave of the held-out recordings, fitted to all training rows; against
  /// a MODEL with the values of the whole set.
  MatrixXd test_error;
  std::shared_ptr<const Rows> test;   ///< their rows, null without any
  MatrixXd test_residual;             ///< (rows x n) with all terms
  /// (n) share of the mean square that curves predict where not all causes were asked about; -1: none does. Empty: all were.
  VectorXd unasked;
  std::vector<Refused> refused;
  int asked = 0;
  int degrees_of_freedom = 1;
};

struct SearchRequest {
  TermScope scope;
  std::vector<std::string> recordings;
  std::vector<double> periods;  ///< [s] of the recordings; 0: no repetition
  PreprocessingOptions preprocessing;
  std::vector<std::string> test;  ///< held-out recordings, on which errors are measured
  PreprocessingOptions test_preprocessing;
  /// Joints without friction in the robot file: plain friction is in the first set, and goes where it is of no use.
  std::set<int> without_friction;
  int most = 20;
  int threads = 0;
  std::function<void(int, int)> progress{};
};

/// Explains the residual of an arm with values on its recordings by the terms of one dictionary.
SearchResult search(const Model& arm, const SearchRequest& request);

/// False for a load (m, m c, ...) of which the intervals of its mass and of the moment that torques see hold zero.
bool is_load(const VectorXd& values, const VectorXd& deviations, double quantile);

/// The arm with the linearised terms of a set.
Model corrected(const Model& arm, const std::vector<Chosen>& chosen);

}  // namespace veridyn::search
