#pragma once

#include <memory>
#include <vector>

#include "simulation/world/arm_points.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/simulation/world.hpp"

namespace veridyn {

struct World::State {
  State(std::vector<WorldArm> given, WorldObjects things);

  struct Arm {
    explicit Arm(WorldArm&& given);
    /// Upper bound of the acceleration of the point per newton, over all directions [1/kg].
    double mobility(const Attachment& at);

    Model model;
    std::unique_ptr<Engine> engine;
    ArmPoints points;
    RigidBodyDynamics rigid;
    MatrixXd rotors, M, J;  // rotors: their contribution to M
    VectorXd column;
    VectorXd q, dq, ddq;  // state of the points, and the acceleration at the substep's start
    VectorXd external;    // mean torque of the objects over a substep
    VectorXd all;         // total torque, with the motors
  };

  struct BodyMotion {
    Eigen::Vector3d p, v, spin_momentum;  // momentum about the centre, in the world
    Eigen::Matrix3d R;
    Eigen::Vector3d force, moment;  // mean over a substep
    Eigen::Vector3d angular_velocity(const Eigen::Vector3d& principal_moments) const;  ///< [rad/s] in the world
  };

  void check() const;  ///< throws InvalidInput, see World
  void check(const Attachment& at, const char* what) const;  ///< `what` names the object in the message
  PointMotion point(const Attachment& at) const;  ///< [m], [m/s] in the world
  /// Adds `share` of a force on that point [N], in the world, to the arm's joint torques; none at a point of the world.
  void push(const Attachment& at, const Eigen::Vector3d& force, double share);
  /// Predicts all points after a share of a substep of h [s].
  void predict(double h);
  void predict_bodies(double h);
  /// Adds `share` of the forces at the present state, and their work over a substep of h [s].
  void add_forces(double share, double h);
  void add_members(double share, double h);
  void add_walls(double share, double h);
  void add_bodies(double share, double h);
  void clear_forces();
  void update_forces();
  int choose_substeps(double dt);
  /// One substep of h [s] with Simpson's mean of the forces; tau: (n) of each arm.
  StepStatus substep(const std::vector<VectorXd>& tau, double h);
  void move_bodies(double h);

  std::vector<Arm> arms;
  WorldObjects objects;
  std::vector<MemberState> members;
  std::vector<BodyMotion> bodies, start;  // present or predicted; at the substep's start
  std::vector<BodyMotion> rates;          // force and moment at the substep's start
  Eigen::Vector3d gravity{0.0, 0.0, 0.0};
  double time = 0.0, work = 0.0;
  double fastest = 0.0, damping_rate = 0.0;  // [rad/s] fastest oscillation, [1/s] fastest decay
  int until_review = 0;
  int count = 1;
};

}  // namespace veridyn
