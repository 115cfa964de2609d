#pragma once

#include <memory>
#include <string>
#include <vector>

#include "veridyn/math/types.hpp"
#include "veridyn/math/vector3.hpp"
#include "veridyn/model/model.hpp"
#include "veridyn/simulation/engine.hpp"
#include "veridyn/simulation/object.hpp"

namespace veridyn {

/// An arm of a World and where it stands. Its gravity is that of its own model, in its base: turn
/// it with the base (R_world_base' g). Held bodies feel the gravity of the first arm.
struct WorldArm {
  Model model;                     ///< true values, as the engine has them
  std::unique_ptr<Engine> engine;  ///< The engine that moves it
  Posed T_world_base = identity_pose();
};

/// What a World holds beside its arms.
struct WorldObjects {
  std::vector<Member> members;
  std::vector<Wall> walls;
  std::vector<HeldBody> bodies;
};

/// Arms that are coupled by objects, moved on together. A step is cut into substeps that are short
/// for the stiffest object (a twelfth of a radian of its fastest oscillation); over each, the
/// engines see the mean of the objects' forces along the motion that is to be expected (Simpson's
/// rule), so that a spring neither makes nor loses energy but for terms of third order.
///
/// Allocates in the constructor alone. One object serves one thread.
class World {
 public:
  /// @throws InvalidInput  an arm without an engine or with another number of joints, an object
  ///                       that names an arm or a frame that is not there, numbers that cannot be.
  World(std::vector<WorldArm> arms, WorldObjects objects);
  ~World();
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;

  int arms() const;

  /// Puts one arm somewhere. Time restarts, energies are counted from zero.
  void set_state(int arm, const VectorRef& q, const VectorRef& dq);
  /// An arm hits something hard, and its state is another at once; time goes on.
  void hit(int arm, const VectorRef& q, const VectorRef& dq);

  /// Moves everything on by dt [s] under constant joint torques, one vector for each arm.
  StepStatus step(const std::vector<VectorXd>& tau, double dt) noexcept;

  double time() const;     ///< [s]
  int substeps() const;    ///< Substeps of the last step
  const VectorXd& q(int arm) const;
  const VectorXd& dq(int arm) const;
  const Engine& engine(int arm) const;

  /// A point in the world [m] and its velocity [m/s], where the arms are now.
  struct PointMotion {
    Eigen::Vector3d position, velocity;
  };
  PointMotion point(const Attachment& at);

  /// State of a member now.
  struct MemberState {
    double length = 0.0;   ///< [m]
    double rate = 0.0;     ///< [m/s]
    double tension = 0.0;  ///< [N]
  };
  const MemberState& member(int index) const;

  /// Lets a member go, or takes it up again with a new rest length [m] above zero.
  void detach(int member);
  void attach(int member, double rest_length);

  /// Force of a body's grasp on the arm that holds it, in the world [N].
  Eigen::Vector3d grasp_force(int body, int grasp) const;
  HeldBody body(int index) const;  ///< Pose and velocity now
  Eigen::Vector3d body_velocity(int index) const;
  Eigen::Vector3d body_spin(int index) const;  ///< [rad/s] in the world

  /// Work that the arms have done on all objects since set_state() [J].
  double work_on_objects() const;
  /// What objects hold: springs, grasps and walls, motion of bodies, without gravity [J].
  double object_energy() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace veridyn
