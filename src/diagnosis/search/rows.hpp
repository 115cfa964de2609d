#pragma once

#include <string>
#include <vector>

#include "veridyn/identification/compressed_recording.hpp"
#include "veridyn/identification/identification.hpp"
#include "veridyn/dynamics/torque_regressor.hpp"
#include "veridyn/identification/regressor_columns.hpp"

namespace veridyn::search {

/// Columns of one term at the rows of a search, for every joint on which it acts.
struct Columns {
  std::vector<int> joints;
  std::vector<MatrixXd> of;  ///< (rows x count) for each of `joints`
  Eigen::Index count() const { return of.empty() ? 0 : of.front().cols(); }
};

/// A stretch of one recording at its full rate.
struct Stretch {
  Segment segment;
  size_t recording = 0;
  std::vector<Eigen::Index> kept;  ///< samples that become rows
  Eigen::Index first = 0;          ///< first of these rows, in order of time
  MatrixXd load;                   ///< (samples x n) torque of the rigid bodies, low-passed
  MatrixXd torque;                 ///< (samples x n) torque of the arm with its values, effects included
};

/// Division of the rows into folds, which are held out together, and into blocks, which count as independent.
/// It depends on the recordings only and is the same for every arm.
struct Folds {
  int count = 0;
  std::vector<int> of_row;    ///< fold of every row, in order of time; -1: the row is next to a border and left out
  std::vector<int> block;     ///< block of every row
  int blocks = 0;
  double errors = 0.0;        ///< gain of a term >= errors * its standard error over blocks
};

/// A column whose coefficient, added to the arm's own value, cannot be negative: friction levels.
struct Level {
  Eigen::Index column;
  double own;
};

/// The rows of recordings for one arm, filtered and decimated as in an identification.
class Rows {
 public:
  /// @param arm  an arm with values, which may be physically impossible.
  Rows(const Model& arm, const std::vector<std::string>& recordings, const PreprocessingOptions& how, int threads = 1);

  const Model& arm() const { return arm_; }
  int joints() const { return arm_.joints(); }
  Eigen::Index rows() const { return rows_; }
  const std::vector<Stretch>& stretches() const { return stretches_; }
  const std::vector<double>& time() const { return time_; }            ///< [s] since the recording began
  const std::vector<size_t>& recording() const { return recording_; }  ///< index of the recording of every row
  const TorqueRegressor& bodies() const { return bodies_; }
  const VectorXd& phi() const { return phi_; }  ///< inertial parameters of all bodies
  const std::vector<std::string>& names() const { return names_; }

  /// (rows x n) measured torque, and its difference from the torque of the arm's values.
  MatrixXd measured, residual;
  /// (rows x n) one if a row counts for a joint, zero if it is excluded.
  MatrixXd used;

  /// Columns of the arm's own free parameters, in one list for all joints: own[i] has the columns of joint i
  /// for the parameters own_parameters[i].
  std::vector<MatrixXd> own;
  std::vector<std::vector<int>> own_parameters;

  /// Filters columns along a stretch and stores them in its rows.
  void put(const Stretch& stretch, MatrixXd columns, MatrixXd& into) const;

 private:
  Model arm_;
  PreprocessingOptions how_;
  TorqueRegressor bodies_;
  VectorXd phi_;
  std::vector<Stretch> stretches_;
  Eigen::Index rows_ = 0;
  std::vector<double> time_;
  std::vector<size_t> recording_;
  std::vector<std::string> names_;
};

/// Folds are whole recordings where there are three or more, else contiguous parts. Equal phases of a motion
/// that repeats belong to one fold; otherwise one period would predict the other.
/// @param periods  [s] of the recordings; 0: no repetition. @param cutoff  [Hz] of the rows' filter, which spreads a row over its neighbours at the borders of folds.
Folds folds_of(const Rows& rows, const std::vector<double>& periods, double cutoff, double block_seconds);

}  // namespace veridyn::search
