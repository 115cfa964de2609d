#pragma once

#include <cmath>
#include <optional>

#include "simulation/plant/plant_forces.hpp"
#include "simulation/plant/sticking.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/simulation/plant.hpp"

namespace veridyn {

/// Index of the first entry that is NaN or infinite.
inline std::optional<int> first_not_finite(const VectorRef& v) {
  for (Eigen::Index i = 0; i < v.size(); ++i) {
    if (!std::isfinite(v[i])) return static_cast<int>(i);
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
  bool evaluate_middle();
  bool last_stage(const VectorRef& tau, double h);
  void change_middle_velocity(double h);
  void add_biases(Instant& at);
  enum class Friction { kDecide, kKeep };
  void accelerate(Instant& at, const VectorRef& tau, Friction friction, VectorXd& ddq);
  void begin(const VectorRef& tau);
  bool nystroem(const VectorRef& tau, double h);
  double error(const VectorRef& tau, double h);
  double velocity(int axis, const VectorXd& dq) const;
  int velocity_sign(int axis) const;  ///< -1, 0 or 1
  double time_to_rest(int axis) const;
  int first_reversal() const;
  bool locate(const VectorRef& tau, double* h);
  StepStatus substep(const VectorRef& tau, double* h, double smallest);
  StepStatus step_failure(bool finite, bool sound);
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
  std::optional<int> failed = {};  // index of the joint with a value that is not finite
};

}  // namespace veridyn
