#pragma once

#include <cmath>
#include <optional>

#include "simulation/plant/plant_forces.hpp"
#include "simulation/plant/sticking.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/simulation/plant.hpp"

namespace veridyn {

/// Joint of the first entry that is NaN or infinite.
inline std::optional<JointIndex> first_not_finite(const VectorRef& v) {
  for (Eigen::Index i = 0; i < v.size(); ++i) {
    if (!std::isfinite(v[i])) return JointIndex{static_cast<int>(i)};
  }
  return std::nullopt;
}

/// One instant of the motion, and the terms there that do not depend on torques.
struct Instant {
  explicit Instant(int n)
      : q(VectorXd::Zero(n)), dq(q), ddq(q), h(q), bias(q), M(MatrixXd::Zero(n, n)), L(M) {}

  double time = 0.0;
  VectorXd q, dq, ddq;
  VectorXd h;     // C dq + g of the rigid bodies
  VectorXd bias;  // h and the effects, except inertia and dry friction
  MatrixXd M;     // mass matrix of the rigid bodies
  MatrixXd L;     // Cholesky factor of M and the rotors
};

/// State of a Plant, and its integrator.
struct Plant::State {
  State(const Model& arm, const VectorXd& phi, const PlantOptions& asked)
      : n(arm.joints()),
        options(asked),
        rigid(arm, phi),
        forces(arm),
        sticking(forces, n),
        here(n),
        there(n),
        stage(n),
        slopes(MatrixXd::Zero(n, n)),
        way(VectorXd::Zero(n)),
        push(way),
        k2(VectorXd::Zero(n)),
        k3(k2),
        k4(k2),
        white(k2),
        torques(k2),
        effects(k2) {}

  bool evaluate(Instant& at);  ///< rigid bodies and biases at its state; false: mass matrix not positive definite
  bool factor(Instant& at);  ///< Cholesky factor L of M and rotors; false: not positive definite
  bool evaluate_middle();  ///< terms of `stage` and their slopes; false as evaluate()
  bool last_stage(const VectorRef& tau, double h);  ///< k4, and the velocity of `there`; false as evaluate()
  void change_middle_velocity(double h);  ///< of `stage`, from its first slope to the second
  void add_biases(Instant& at);  ///< sets bias to h and the smooth forces
  enum class Friction { kDecide, kKeep };
  void accelerate(Instant& at, const VectorRef& tau, Friction friction, VectorXd& ddq);  ///< sets ddq, loads and biases; kDecide: also which axes slide
  void begin(const VectorRef& tau);  ///< sets ddq of `here` and which axes slide
  bool nystroem(const VectorRef& tau, double h);  ///< sets `there`, h after `here`; false as evaluate()
  double error(const VectorRef& tau, double h);  ///< largest ratio of estimated to allowed error; sets `failed` to its joint
  double velocity(int axis, const VectorXd& dq) const;  ///< axes: those of dry friction, then those with memory
  int velocity_sign(int axis) const;  ///< -1, 0 or 1
  double time_to_rest(int axis) const;  ///< speed, not a time, [rad/s] or [m/s], below which the axis counts as at rest
  int first_reversal() const;  ///< axis as in velocity(); -1: none
  bool locate(const VectorRef& tau, double* h);  ///< shortens h up to the first reversal; false: mass matrix not positive definite
  StepStatus substep(const VectorRef& tau, double* h, double smallest);  ///< at most *h [s]; sets *h to its length, and `here` to its end
  StepStatus step_failure(bool finite, bool sound);  ///< reason why a substep was refused; sets `failed`
  void commit();  ///< makes `there` the present instant; axes that came to rest stick
  void add_up_effects();  ///< torques of all effects at the present instant

  int n;
  PlantOptions options;
  RigidBodyDynamics rigid;
  PlantForces forces;
  Sticking sticking;
  Instant here, there, stage;
  MatrixXd slopes;     // derivatives of h by the velocity
  VectorXd way, push;  // displacement to the last stage, and the change of M ddq + h over it
  VectorXd k2, k3, k4, white, torques, effects;
  double next_h = 0.0;
  Work work;
  std::optional<JointIndex> failed = {};  // joint with a value that is not finite
};

}  // namespace veridyn
