#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "regressor/column_source.hpp"
#include "excitation/limits/frame_points.hpp"
#include "excitation/limits/link_gap.hpp"
#include "veridyn/excitation/workspace_limits.hpp"
#include "kinematics/motion_limits.hpp"

namespace veridyn {

/// A quantity that has to stay within bounds along a motion.
struct LimitSignal {
  std::string name;  ///< "speed of yaw", "torque of pitch", "x of tool", ...
  std::string unit;
  double lower;
  double upper;
  double scale;  ///< scale by which margins of different units are compared
  LimitKind kind = LimitKind::kPlace;
  std::optional<JointIndex> joint = {};  ///< nullopt: kPlace
};

/// Share of torque limits that is used: a supervisor stops an arm whose motors saturate, and the friction is
/// still unknown.
constexpr double kTorqueOfSupervisor = 0.95;

/// All bounded quantities as signals along a motion. Signals 0 .. 3 n - 1 are q, dq, ddq
/// themselves.
class LimitSignals {
 public:
  /// @param powered  the arm with values, if torques are limited; its efforts are the bounds.
  /// @param braking  [1/s] if above zero, the position after braking, q + dq / braking, must be within the
  /// range as well.
  /// @throws InvalidInput  an unknown frame, bounds in the wrong order, no values.
  LimitSignals(const Model& arm, const MotionLimits& joints, const WorkspaceLimits& workspace,
               const std::optional<Model>& powered, double braking = 0.0);

  int count() const { return static_cast<int>(signals_.size()); }
  int joints() const { return joints_; }
  const LimitSignal& operator[](int k) const { return signals_[k]; }

  /// The signals that follow q, dq, ddq: (rows x count() - 3 n).
  MatrixXd values(const MotionSamples& motion) const;

  /// Derivatives of values() with respect to q, dq, ddq of the same row: one matrix (rows x 3 n) for each
  /// signal. The dependence on earlier rows through memories is neglected.
  std::vector<MatrixXd> derivatives(const MotionSamples& motion) const;

 private:
  void add_stops(const MotionLimits& joints);
  void add_torques(const Model& powered);
  void add_workspace(const Model& arm, const WorkspaceLimits& workspace);
  std::optional<FrameIndex> frame_index(const Model& arm, const std::string& name) const;
  MatrixXd torques(const MotionSamples& motion) const;
  void torque_derivatives(const MotionSamples& motion, std::vector<MatrixXd>& slopes) const;
  double workspace_signal(const FramePoints& at, size_t k, Eigen::RowVectorXd* slope) const;

  // A geometric signal and the points that it measures.
  struct Geometry {
    enum class Kind { kCoordinate, kDistance, kInsertion } kind;
    int axis;
    std::optional<FrameIndex> frame, other;
    Eigen::Vector3d point, other_point;
  };

  double gap(const FramePoints& at, size_t k, Eigen::RowVectorXd* slope) const;
  double geometric(const FramePoints& at, size_t k, Eigen::RowVectorXd* slope) const {
    return k < geometries_.size() ? workspace_signal(at, k, slope) : gap(at, k - geometries_.size(), slope);
  }
  size_t geometric_count() const { return geometries_.size() + gaps_.size(); }

  int joints_;
  Model arm_;
  std::vector<LimitSignal> signals_;
  double braking_;  // [1/s]; 0: braking is not considered
  // Data of the torque limits.
  std::vector<int> torque_joints_;
  std::unique_ptr<TorqueRegressor> bodies_;
  VectorXd phi_;
  std::vector<std::shared_ptr<const ColumnSource>> effects_;
  std::vector<VectorXd> effect_values_;
  std::vector<Geometry> geometries_;
  std::vector<LinkGap> gaps_;  // come after the other geometric signals
};

}  // namespace veridyn
