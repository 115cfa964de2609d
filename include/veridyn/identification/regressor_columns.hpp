#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "veridyn/dynamics/torque_regressor.hpp"
#include "veridyn/regressor/standard_parameters.hpp"
#include "veridyn/recordings/preprocessing.hpp"

namespace veridyn {

/// Rows of one joint over a segment of samples: A * parameters ~ b.
struct JointRows {
  std::vector<int> parameters;  ///< indices of the standard parameters that act on this joint
  MatrixXd A;                   ///< (samples x parameters)
  VectorXd b;                   ///< (samples) torque [N m] or [N]
  VectorXd time;                ///< (samples) [s] time since the recording began
};

/// Computes rows of least squares from segments of samples, filtered and decimated according to the options.
/// Parameters that the robot file declares as known have no column: their torque is subtracted from b.
class RegressorColumns {
 public:
  RegressorColumns(const Model& arm, const PreprocessingOptions& options);

  const std::vector<StandardParameter>& parameters() const { return parameters_; }
  const std::vector<int>& parameters_of(JointIndex joint) const {
    return of_joint_[joint.value];
  }

  /// One JointRows per joint, from the usable samples of the segment's core.
  std::vector<JointRows> rows(const Segment& segment) const;

  /// Joints first .. end - 1.
  struct Joints {
    int first, end;
  };

  /// Divides the joints into groups, such that the columns of a group over this many rows need a few megabytes.
  std::vector<Joints> groups(Eigen::Index rows) const;

  /// Like rows() for the joints of one group, in its order.
  std::vector<JointRows> rows(const Segment& segment, Joints joints) const;

  /// Measured torque with the filter of rows() and predict(), (rows x n).
  MatrixXd filtered_torque(const Segment& segment) const;

  /// Modelled and measured torque, both with the same filter, for given parameters, on all rows:
  /// also outside of the core and in excluded intervals. (rows x n) each.
  struct Prediction {
    MatrixXd measured;
    MatrixXd modelled;
  };
  Prediction predict(const Segment& segment, const VectorRef& values) const;

  /// True if the options exclude this instant of the joint; `excluded_intervals` in the options must belong
  /// to this recording. @param time  [s] since the recording began.
  bool is_excluded(JointIndex joint, double time) const;

 private:
  std::vector<MatrixXd> raw_columns(const Segment& segment, Joints joints) const;  ///< unfiltered, (samples x parameters_of) for each joint
  MatrixXd columns_of(const EffectTerm& term, const Segment& segment, MatrixXd& load) const;
  MatrixXd torque(const Segment& segment, const VectorRef& values) const;
  template <typename Put>
  void for_channel_errors(const Segment& segment, const Put& put) const;
  void filter(MatrixXd& columns, double dt) const;  ///< in place; only with matched filtering
  void smooth_load(MatrixXd& load, double dt) const;
  std::vector<Eigen::Index> kept_samples(const Segment& segment, Eigen::Index joint) const;  ///< samples of the core that become rows

  Model arm_;
  PreprocessingOptions options_;
  TorqueRegressor bodies_;
  std::vector<StandardParameter> parameters_;
  std::vector<Eigen::Index> first_of_effect_;  // index of its first parameter
  std::vector<std::vector<int>> of_joint_;
};

}  // namespace veridyn
