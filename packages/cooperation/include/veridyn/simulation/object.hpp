#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// Attachment point of an object, in a frame of an arm or in the world.
struct Attachment {
  std::optional<int> arm = {};  ///< index in the World; nullopt: the world itself
  FrameIndex frame;
  Eigen::Vector3d offset{0.0, 0.0, 0.0};  ///< [m] position in the frame, or in the world
};

/// A massless spring and damper between two points, which acts along the line between them:
///
///   tension = K (l - l0) + C dl/dt
///
/// Thesis (6.1) with the errata: the damping acts on the velocity, so that it does not depend on the time
/// step.
struct Member {
  std::string name;
  Attachment from, to;
  double stiffness = 0.0;    ///< K [N/m]
  double damping = 0.0;      ///< C [N s/m]
  double rest_length = 0.0;  ///< l0 [m]
  bool pulls_only = false;   ///< a string: it can be slack and never pushes
  bool attached = true;
};

/// Stiffness of a member that counts as rigid: a bar of 2e5 N/m with about a tenth of the critical
/// damping for half a kilogram. It stretches by 0.025 mm under 5 N.
constexpr double kRigidStiffness = 2e5;  ///< [N/m]
constexpr double kRigidDamping = 60.0;   ///< [N s/m]

/// Force of a member [N] at a length [m] and its rate [m/s], positive when the member pulls its ends together; zero where it is detached or slack.
double tension(const Member& member, double length, double rate) noexcept;

/// Stored energy at that length [J].
double elastic_energy(const Member& member, double length) noexcept;

/// A plane that pushes a point out along its normal with the force (K + S * depth) * depth + C * rate of the
/// depth, never below zero.
struct Wall {
  Eigen::Vector3d point{0.0, 0.0, 0.0};   ///< [m] a point of the plane, in the world
  Eigen::Vector3d normal{0.0, 0.0, 1.0};  ///< outward unit normal
  double stiffness = 0.0;                 ///< K [N/m]
  double stiffening = 0.0;                ///< S [N/m^2]
  double damping = 0.0;                   ///< C [N s/m]
  double drag = 0.0;                      ///< [N s/m] along the plane, while the point is below it
  Attachment touches;
};

/// Contact force along the normal [N] at a depth [m] below the plane and its rate [m/s].
double contact_force(const Wall& wall, double depth, double rate) noexcept;
/// Contact force on a point that moves [N], in the world: along the normal, and against its motion
/// along the plane.
Eigen::Vector3d contact_force(const Wall& wall, const Eigen::Vector3d& position,
                              const Eigen::Vector3d& velocity) noexcept;

/// A rigid body held by compliant grasps, each a spring and a damper in all directions between a
/// point of an arm and one of the body (a fingertip: forces, no moments).
struct HeldBody {
  struct Grasp {
    Attachment held_by;
    Eigen::Vector3d point_body{0.0, 0.0, 0.0};  ///< [m] grasped point, in the axes of the body from its centre
    double stiffness = 0.0;                     ///< [N/m]
    double damping = 0.0;                       ///< [N s/m]
    bool attached = true;
  };
  double mass = 0.0;                        ///< [kg]
  Eigen::Vector3d inertia{0.0, 0.0, 0.0};   ///< [kg m^2] about its centre, along its axes
  Eigen::Vector3d position{0.0, 0.0, 0.0};  ///< [m] position of its centre in the world
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< R_world_body
  std::vector<Grasp> grasps;
};

}  // namespace veridyn
