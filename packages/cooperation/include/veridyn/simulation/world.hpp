#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <vector>

#include "veridyn/math/types.hpp"
#include "veridyn/model/model.hpp"
#include "veridyn/simulation/engine.hpp"
#include "veridyn/simulation/object.hpp"

namespace veridyn {

/// An arm of a World with the pose of its base. Gravity is that of its own model, in its base:
/// rotate it with the base (R_world_base' g). Held bodies have the gravity of the first arm.
struct WorldArm {
  Model model;                     ///< true values, as in the engine
  std::unique_ptr<Engine> engine;  ///< engine that moves it
  Eigen::Isometry3d T_world_base = Eigen::Isometry3d::Identity();
};

/// Contents of a World beside its arms.
struct WorldObjects {
  std::vector<Member> members;
  std::vector<Wall> walls;
  std::vector<HeldBody> bodies;
};

/// Arms coupled by objects, simulated together. A step is divided into substeps that are short for
/// the stiffest object (a twelfth of a radian of its fastest oscillation); over each, the engines
/// see the mean of the objects' forces along the predicted motion (Simpson's rule), so that a
/// spring neither generates nor loses energy up to terms of third order.
///
/// Allocates in the constructor alone. One object serves one thread.
class World {
 public:
  /// @throws InvalidInput  an arm without an engine or with another number of joints, an object
  /// that names an arm or a frame that does not exist, numbers out of range.
  World(std::vector<WorldArm> arms, WorldObjects objects);
  ~World();
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;

  int arms() const;

  /// Sets the state of one arm. Time and energies restart at zero.
  void set_state(int arm, const VectorRef& q, const VectorRef& dq);
  /// Changes the state of an arm instantaneously, as in a hard impact; time continues.
  void hit(int arm, const VectorRef& q, const VectorRef& dq);

  /// Advances everything by dt [s] under constant joint torques, one vector for each arm.
  StepStatus step(const std::vector<VectorXd>& tau, double dt) noexcept;

  double time() const;     ///< [s] since set_state()
  int substeps() const;    ///< number of substeps of the last step
  const VectorXd& q(int arm) const;
  const VectorXd& dq(int arm) const;
  const Engine& engine(int arm) const;

  /// A point in the world [m] and its velocity [m/s] at the present state of the arms.
  struct PointMotion {
    Eigen::Vector3d position, velocity;
  };
  PointMotion point(const Attachment& at);

  /// State of a member.
  struct MemberState {
    double length = 0.0;   ///< [m]
    double rate = 0.0;     ///< [m/s] rate of the length
    double tension = 0.0;  ///< [N] positive if the member pulls
  };
  const MemberState& member(int index) const;

  void detach(int member);  ///< releases a member
  /// Attaches a released member with a new rest length [m] above zero.
  void attach(int member, double rest_length);

  /// Force of a body's grasp on the arm that holds it, in the world [N].
  Eigen::Vector3d grasp_force(int body, int grasp) const;
  HeldBody body(int index) const;  ///< as given, with its present pose
  Eigen::Vector3d body_velocity(int index) const;  ///< [m/s] velocity of its centre in the world
  Eigen::Vector3d body_spin(int index) const;  ///< [rad/s] angular velocity in the world

  /// Work of the arms on all objects since set_state() [J].
  double work_on_objects() const;
  /// Energy of the objects: springs, grasps and walls, motion of bodies, without gravity [J].
  double object_energy() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace veridyn
