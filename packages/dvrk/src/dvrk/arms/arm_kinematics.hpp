#pragma once

#include <Eigen/Core>
#include <array>

#include "dvrk/arms/arm_facts.hpp"

namespace veridyn::dvrk {

// Closed forms of the arms' inverse kinematics, for control loops: constructors throw InvalidInput if an
// arm's DH rows have another form; the functions never throw or allocate. Poses are those of frame_pose() of
// arm_model(); they must be rigid, which is not checked.

enum class InverseStatus {
  kDone,           ///< q reaches the pose, within the limits
  kOutsideLimits,  ///< q reaches the pose, but at least one joint is outside of its limits
  kSingular,       ///< the pose does not determine some joints, which are taken from `near`
  kOutOfReach,     ///< no q reaches the pose; q is `near`
};

template <int n>
struct InverseSolution {
  InverseStatus status = InverseStatus::kOutOfReach;
  Eigen::Matrix<double, n, 1> q = Eigen::Matrix<double, n, 1>::Zero();
};

/// Distance [m], or sine of an angle times distance, below which directions are undetermined: errors of
/// rounding (1e-16 m) become 1e-7 rad there.
constexpr double kSingularDistance = 1e-9;

/// Ranges of the joints of a chain.
template <int n>
struct JointRanges {
  Eigen::Matrix<double, n, 1> lower;
  Eigen::Matrix<double, n, 1> upper;
  std::array<bool, n> turns{};  ///< joints with angles, which may change by whole turns

  explicit JointRanges(const ArmFacts& arm);
  /// Changes angles by whole turns: into the range and, among several possibilities, nearest to `near`.
  void wrap(Eigen::Matrix<double, n, 1>& q, const Eigen::Matrix<double, n, 1>& near) const noexcept;
  /// True if every joint is within its range, up to 1e-9 for rounding.
  bool contain(const Eigen::Matrix<double, n, 1>& q) const noexcept;
};

extern template struct JointRanges<3>;
extern template struct JointRanges<4>;
extern template struct JointRanges<6>;
extern template struct JointRanges<7>;

/// Patient side manipulator: q = yaw, pitch, insertion, roll, wrist pitch, wrist yaw. The base
/// frame stands in the remote centre, z up at the usual mounting.
///
/// The shaft points along u = (s1 c2, -s2, -c1 c2) and ends at u (q3 - remote + shaft), where the
/// axis of wrist pitch is. The inverse uses that the shaft, the axis of wrist yaw and the link between them
/// lie in one plane through the remote centre, perpendicular to the axis of wrist pitch.
class PsmKinematics {
 public:
  using Joints = Eigen::Matrix<double, 6, 1>;

  explicit PsmKinematics(const ArmFacts& arm);

  /// The solution within the limits that is nearest to `near`, out of up to four.
  ///
  /// Singular where the shaft's end is in the remote centre (q3 = 0.0156 m), where the axis of
  /// wrist yaw passes through it (wrist pitch beyond 90 degrees) and where the shaft lies along the
  /// axis of yaw (pitch at 90 degrees). Joints that the pose leaves free are then taken from
  /// `near`, and q still reaches the pose.
  InverseSolution<6> inverse(const Eigen::Matrix4d& T_base_tip, const Joints& near) const noexcept;

 private:
  Joints candidate(const Eigen::Matrix4d& T_base_last, double wrist_side, double shaft_side,
                   const Joints& near, bool& singular) const noexcept;

  double remote_;  ///< [m] insertion at which the frame of insertion is in the remote centre
  double shaft_;   ///< [m] distance from there to the wrist
  double wrist_;   ///< [m] distance of the axes of the wrist
  Eigen::Matrix4d T_tip_last_;
  JointRanges<6> ranges_;
};

/// Endoscope manipulator: q = yaw, pitch, insertion, roll.
class EcmKinematics {
 public:
  using Joints = Eigen::Vector4d;

  explicit EcmKinematics(const ArmFacts& arm);

  /// The arm has four joints: a pose whose z axis misses the remote centre by more than 1e-6 m is
  /// out of reach. Yaw and pitch come from that axis, so that the tip may be in the remote centre.
  InverseSolution<4> inverse(const Eigen::Matrix4d& T_base_tip, const Joints& near) const noexcept;

 private:
  double remote_;
  double shaft_;
  JointRanges<4> ranges_;
};

/// Master arm: q = yaw, shoulder, elbow, platform, wrist pitch, wrist yaw, roll (joints, not
/// motors). The last four axes meet in one point, the wrist: one of them is free, and the caller
/// chooses the platform's angle.
class MtmKinematics {
 public:
  using Joints = Eigen::Matrix<double, 7, 1>;

  explicit MtmKinematics(const ArmFacts& arm);

  /// Yaw, shoulder and elbow for a position of the wrist [m]: of up to four solutions the one within
  /// the limits nearest to `near`. Singular where the wrist is on the axis of yaw (yaw is `near`'s). Where the
  /// arm is stretched two solutions meet, and errors grow to the square root of rounding (1e-8
  /// rad).
  InverseSolution<3> inverse_position(const Eigen::Vector3d& wrist,
                                      const Eigen::Vector3d& near) const noexcept;

  /// All joints; the platform stays at near[3]. Singular also where wrist yaw is at +-90 degrees
  /// (wrist pitch is then taken from `near`).
  InverseSolution<7> inverse(const Eigen::Matrix4d& T_base_tip, const Joints& near) const noexcept;

 private:
  Eigen::Matrix3d platform_orientation(const Joints& q) const noexcept;

  double height_;   ///< [m] height of the shoulder
  double upper_;    ///< [m] length of the upper arm
  double forearm_;  ///< [m]
  double offset_;   ///< [m] offset of the wrist across the forearm
  Eigen::Matrix4d T_tip_last_;
  JointRanges<7> ranges_;
  JointRanges<3> position_ranges_;  ///< Position ranges of yaw, shoulder, elbow
};

}  // namespace veridyn::dvrk
