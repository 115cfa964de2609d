#pragma once

#include <Eigen/Geometry>
#include <string>

#include "veridyn/kinematics/point_motion.hpp"
#include "veridyn/math/types.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// A vector with its linear entries first: [v; omega], [force; moment], [position; angles].
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// The controlled point of an arm.
struct Tip {
  std::string frame;                                      ///< frame of the model
  Eigen::Vector3d offset_frame{Eigen::Vector3d::Zero()};  ///< [m] position of the point in that frame
};

/// The frame that the most joints move; if there are several, the last one.
std::string default_tip(const Model& arm);

/// Pose, geometric Jacobian and its rate of the tip, as frame_pose() and frame_jacobian() define them, for control
/// loops: only the frames above the tip are visited, and nothing allocates after the constructor.
///
///   TipKinematics tip(arm, {"tool", {0, 0, 0.01}});
///   tip.update(q, dq);  // then tip.position(), tip.jacobian()
class TipKinematics {
 public:
  /// @throws InvalidInput  the arm has no such frame, or the offset is not finite.
  TipKinematics(const Model& arm, const Tip& tip);

  /// @param q, dq  n entries each, true positions: see JointSensors.
  /// Vectors have the sizes of the constructor; debug builds assert it.
  void update(const VectorRef& q, const VectorRef& dq) noexcept;

  int joints() const { return motion_.joints(); }

  /// T_world_tip: position [m] and rotation. The tip's axes are those of its frame.
  const Eigen::Vector3d& position() const { return position_; }
  const Eigen::Matrix3d& rotation() const { return rotation_; }

  /// [v; omega] = J dq, (6 x n), written in the world, linear rows first; and dJ/dt.
  const MatrixXd& jacobian() const { return motion_.jacobian(); }
  const MatrixXd& jacobian_rate() const { return motion_.jacobian_rate(); }

  /// Twist [v; omega] of the tip in the world [m/s, rad/s].
  const Vector6d& twist() const { return twist_; }

 private:
  PointMotion motion_;
  Eigen::Vector3d position_{Eigen::Vector3d::Zero()};
  Eigen::Matrix3d rotation_{Eigen::Matrix3d::Identity()};
  Vector6d twist_{Vector6d::Zero()};
};

}  // namespace veridyn
