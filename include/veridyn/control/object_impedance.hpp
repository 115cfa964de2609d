#pragma once

#include <Eigen/Core>
#include <vector>

#include "veridyn/control/cooperative_controller.hpp"

namespace veridyn {

/// Pose and motion of an object, in the world.
struct ObjectMotion {
  Eigen::Vector3d position{Eigen::Vector3d::Zero()};      ///< [m] centre of mass
  Eigen::Matrix3d rotation{Eigen::Matrix3d::Identity()};  ///< R_world_object
  Eigen::Vector3d velocity{Eigen::Vector3d::Zero()};      ///< [m/s]
  Eigen::Vector3d spin{Eigen::Vector3d::Zero()};          ///< [rad/s]
  Eigen::Vector3d acceleration{Eigen::Vector3d::Zero()};  ///< [m/s^2]; references only
  Eigen::Vector3d spin_rate{Eigen::Vector3d::Zero()};     ///< [rad/s^2]; references only
};

struct ObjectImpedanceOptions {
  double mass = 0.0;  ///< [kg] mass of the object's model
  /// [kg m^2] about its axes, of the object's model
  Eigen::Vector3d inertia{Eigen::Vector3d::Zero()};
  Eigen::Vector3d gravity{0.0, 0.0, -9.81};  ///< [m/s^2]
  std::vector<Eigen::Vector3d> grasps;  ///< [m] points held by the hands, in the object's frame
  // Desired impedance of the object, in all directions.
  double wanted_mass = 1.0;        ///< M_d [kg]
  double damping = 0.0;            ///< [N s/m]
  double stiffness = 0.0;          ///< [N/m]
  double wanted_inertia = 0.01;    ///< [kg m^2]
  double angular_damping = 0.0;    ///< [N m s/rad]
  double angular_stiffness = 0.0;  ///< [N m/rad]
};

/// Multiple impedance control: the object has its own impedance, and so has each hand, about the same motion.
/// The force for the object's inertia and weight is fed forward to the hands, so that a heavy object neither
/// lags nor sags:
///
///   a   = a_d + (D (v_d - v) + K (x_d - x) + f_env) / M_d        and likewise for turning
///   F   = m (a - g) - f_env,   N = I alpha + omega x I omega - n_env
///   f_i = F / hands + y x (r_i - mean r) + internal forces along the lines between the hands
///
/// where y makes the f_i add up to the moment N as well, with the smallest forces. Two hands cannot
/// exert a moment about the line between them: that part of N is dropped, and F is unaffected.
///
/// Targets contain x_i = x_d + R_d r_i and the force f_i; the hands' own impedance combines them as
/// x_i + f_i / K_hand. Source: Moosavian and Papadopoulos, Robotica 16(4), 1998, which the thesis
/// recommends. Nothing allocates after the constructor.
class ObjectImpedance {
 public:
  /// @throws InvalidInput  no grasps, numbers below zero or not finite, a wanted mass or inertia of
  /// zero.
  explicit ObjectImpedance(const ObjectImpedanceOptions& options);

  /// Sets the force with which two hands pull against each other [N]; tension is positive. False, without a change, for equal
  /// hands, hands that do not exist, and a force that is not finite.
  bool set_internal_force(int hand, int other, double force) noexcept;

  /// Estimates the object's motion from its hands, [m] and [m/s] in the world: Gauss-Newton steps from the last estimate. Two hands do
  /// not determine a rotation about the line between them, which keeps its last value. If a number is not
  /// finite, the whole estimate keeps its last value.
  const ObjectMotion& estimate(const std::vector<Eigen::Vector3d>& positions,
                               const std::vector<Eigen::Vector3d>& velocities) noexcept;

  /// Sets the initial estimate.
  void reset(const ObjectMotion& motion) noexcept { now_ = motion; }

  /// Computes the hands' targets. @param force, moment  of the environment on the object, if known [N, N m].
  const std::vector<TipTarget>& update(const ObjectMotion& now, const ObjectMotion& wanted,
                                       const Eigen::Vector3d& force,
                                       const Eigen::Vector3d& moment) noexcept;

  int hands() const { return static_cast<int>(targets_.size()); }

 private:
  void distribute(const ObjectMotion& now, const Eigen::Vector3d& F,
                  const Eigen::Vector3d& N) noexcept;  ///< sets the targets' forces to the smallest with resultant F and moment N

  ObjectImpedanceOptions options_;
  double reach_;              // [m] mean distance of the grasps
  Eigen::MatrixXd internal_;  // (hands x hands)
  std::vector<TipTarget> targets_;
  ObjectMotion now_;
};

}  // namespace veridyn
