#include "linear_arm.hpp"

#include "veridyn/control/arm_state.hpp"
#include "veridyn/control/friction_compensation.hpp"
#include "veridyn/control/task_inverse.hpp"

namespace veridyn {
namespace {

constexpr double kStep = 1e-5;      // [rad], [m] step of central differences, whose error is about 1e-10
constexpr double kSlow = 0.01;      // [rad/s], [m/s] at which the increase of friction with speed is evaluated

// Torques of an arm at rest with a force f on the tip, in the arm's own base.
VectorXd holding_torques(ArmState& state, const VectorXd& q, const VectorXd& rest,
                 const Eigen::Vector3d& f_base) {
  state.update(q, rest);
  return state.bias() - state.tip().jacobian().topRows(3).transpose() * f_base;
}

// (n x n) Derivative of holding_torques() by the joint positions.
MatrixXd torque_jacobian(ArmState& state, const VectorXd& q, const Eigen::Vector3d& f_base) {
  const VectorXd rest = VectorXd::Zero(q.size());
  MatrixXd out(q.size(), q.size());
  VectorXd at = q;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    at[i] = q[i] + kStep;
    const VectorXd up = holding_torques(state, at, rest, f_base);
    at[i] = q[i] - kStep;
    out.col(i) = (up - holding_torques(state, at, rest, f_base)) / (2.0 * kStep);
    at[i] = q[i];
  }
  return out;
}

// Friction that increases with the speed of a sliding arm, (n x n), without dry friction.
MatrixXd speed_dependent_friction(const Model& model, const ArmState& state) {
  FrictionOptions options;
  options.share = 1.0;
  FrictionCompensation friction(model, options);
  friction.set_axis_states(state);
  MatrixXd out = MatrixXd::Zero(model.joints(), model.joints());
  for (int k = 0; k < friction.axes(); ++k) {
    const auto odd = [&](double speed) {
      return 0.5 * (friction.sliding(k, 1.0, speed) - friction.sliding(k, -1.0, speed));
    };
    const double drag = (odd(2.0 * kSlow) - odd(kSlow)) / kSlow;
    const VectorXd& c = friction.axis(k);
    out += drag * c * c.transpose();
  }
  return out;
}

}  // namespace

LinearArm linear_arm(const ScenarioModels& models, const ScenarioArm& arm, const VectorXd& q,
                     const Eigen::Vector3d& force, const Eigen::Vector3d& exerted) {
  const Tip tip{arm.frame, arm.offset};
  const VectorXd rest = VectorXd::Zero(q.size());
  LinearArm out;
  ArmState real(models.real, tip);
  out.G = torque_jacobian(real, q, models.R_world_base.transpose() * force);
  real.update(q, rest);
  out.M = real.mass_matrix();
  out.J = models.R_world_base * real.tip().jacobian().topRows(3);
  out.tip = models.p_world_base + models.R_world_base * real.tip().position();
  out.D = speed_dependent_friction(models.real, real);
  ArmState known(models.known, tip);
  out.R_world_base = models.R_world_base_known;
  out.G_known = torque_jacobian(known, q, -out.R_world_base.transpose() * exerted);
  known.update(q, rest);
  out.M_known = known.mass_matrix();
  out.J_base = known.tip().jacobian().topRows(3);
  out.J_known = out.R_world_base * out.J_base;
  TaskInverse inverse(models.known, tip, TaskRows::kPosition);
  inverse.update(known.tip().jacobian());
  out.damped_inverse = MatrixXd::Zero(q.size(), 3);
  VectorXd column = rest;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    Vector6d a = Vector6d::Zero();
    a[axis] = 1.0;
    inverse.solve(a, rest, column);
    out.damped_inverse.col(axis) = column;
  }
  out.null_space = MatrixXd::Identity(q.size(), q.size()) - out.damped_inverse * out.J_base;
  return out;
}

}  // namespace veridyn
