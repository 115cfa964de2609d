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
  std::vector<MatrixXd> of;  ///< (rows x count), one for each of `joints`
  Eigen::Index count() const { return of.empty() ? 0 : of.front().cols(); }
};

/// A stretch of one recording at its full rate.
struct Stretch {
  Segment segment;
  size_t recording = 0;
  std::vector<Eigen::Index> kept;  ///< samples that become rows
  Eigen::Index first = 0;          ///< first of these rows, in order of time
  MatrixXd load;                   ///< (samples x n) torque of the rigid bodies, low-passed
  MatrixXd torque;                 ///< (samples x n) torque of the arm's values, effects included
};

/// Which rows are held out together, and which blocks of them count as independent. Both follow from the
/// recordings alone and are the same for every arm.
struct Folds {
  int count = 0;
  std::vector<int> of_row;    ///< in order of time; -1: at a border between two folds, left out
  std::vector<int> block;     ///< of every row
  int blocks = 0;
  double errors = 0.0;        ///< standard errors over blocks that a gain must exceed
};

/// A column whose coefficient, added to the arm's own value, cannot be negative: friction levels.
struct Level {
  Eigen::Index column;
  double own;
};

/// The rows of recordings as one arm takes them: filtered and decimated as identification does it.
class Rows {
 public:
  /// @param arm  with values, which need not be possible ones.
  Rows(const Model& arm, const std::vector<std::string>& recordings, const PreprocessingOptions& how);

  const Model& arm() const { return arm_; }
  int joints() const { return arm_.joints(); }
  Eigen::Index rows() const { return rows_; }
  const std::vector<Stretch>& stretches() const { return stretches_; }
  const std::vector<double>& time() const { return time_; }            ///< [s] since the recording began
  const std::vector<size_t>& recording() const { return recording_; }  ///< of every row
  const TorqueRegressor& bodies() const { return bodies_; }
  const VectorXd& phi() const { return phi_; }  ///< inertial parameters of all bodies
  const std::vector<std::string>& names() const { return names_; }

  /// (rows x n) measured torque and what the arm's values predict of it.
  MatrixXd measured, residual;
  /// (rows x n) one where a row counts for a joint, zero where it is left out.
  MatrixXd used;

  /// Columns of the arm's own free parameters, in one list for all joints: entry i of `own` are the
  /// columns of joint i for the parameters own_parameters[i].
  std::vector<MatrixXd> own;
  std::vector<std::vector<int>> own_parameters;

  /// Filters columns along a stretch and puts them into the rows of the stretch.
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

/// Whole recordings where there are three or more, else contiguous parts; equal phases of a motion that
/// repeats are held out together, or one period would teach the other.
/// @param periods  [s] of the recordings; 0: no repetition.
Folds folds_of(const Rows& rows, const std::vector<double>& periods, double cutoff);

}  // namespace veridyn::search
