#include "dvrk/run/controllers/model_controller.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

const ModelControlOptions& checked(const ModelControlOptions& options, const Model& model,
                                   const PidGains& rest, const VectorXd& largest) {
  require(model.joints() >= 1 && model.joints() <= largest.size(), "model '", model.name(),
          "': found ", model.joints(), " joints, expected 1 to ", largest.size(),
          ", which the arm has.");
  require(options.position_steps.size() == 0 || options.position_steps.size() == largest.size(), "model '",
          model.name(), "': found steps of ", options.position_steps.size(), " encoders, expected ",
          largest.size(), ".");
  require(model.inertial_values().has_value(), "model '", model.name(),
          "' has no values; expected a MODEL that identify or diagnose wrote.");
  require(rest.p.size() == largest.size(), "model '", model.name(), "': found gains of ",
          rest.p.size(), " joints, expected ", largest.size(), ".");
  for (const double v :
       {options.frequency, options.tip_mass, options.stiffness, options.longest_gap})
    require(v > 0.0 && std::isfinite(v), "controller: found an option of ", v,
            ", expected a number above zero.");
  require(options.model_error >= 0.0 && options.model_error <= 1.0,
          "controller: found a share for errors of the model of ", options.model_error,
          ", expected 0 to 1.");
  return options;
}

SafetyLimits limits_of(const Model& model, const VectorXd& largest, const ModelControlOptions& options) {
  const VectorXd most = JointSensors(model).largest_true_torques(largest.head(model.joints()));
  SafetyLimits limits = safety_limits(model, most.maxCoeff());
  limits.torque = limits.torque.cwiseMin(most);
  limits.sensor_age = limits.overrun = options.longest_gap;
  if (options.position_steps.size() > 0) limits.resolution = options.position_steps.head(model.joints());
  return limits;
}

JointGains joint_gains(int joints, const ModelControlOptions& options) {
  if (options.joint_gains) return *options.joint_gains;
  const double frequency = options.frequency;
  return {VectorXd::Constant(joints, frequency * frequency),
          VectorXd::Constant(joints, 2.0 * frequency)};
}

ImpedanceGains tip_gains(const ModelControlOptions& options) {
  if (options.tip_gains) return *options.tip_gains;
  ImpedanceGains gains;
  gains.mass.setConstant(options.tip_mass);
  gains.stiffness.setConstant(options.stiffness);
  gains.damping.setConstant(2.0 * std::sqrt(options.tip_mass * options.stiffness));
  return gains;
}

PidGains without_first(PidGains gains, int joints) {
  for (VectorXd* one : {&gains.p, &gains.i, &gains.d}) one->head(joints).setZero();
  return gains;
}

Tip tip_of(const ModelControlOptions& options, const Model& model) {
  return {options.tip.empty() ? default_tip(model) : options.tip};
}

constexpr double kIntegralShare = 0.5;  // share of the largest torque, as in a run with a PID

}  // namespace

ModelController::ModelController(const Model& model, const PidGains& rest, const VectorXd& largest,
                                 const ModelControlOptions& options)
    : options_(checked(options, model, rest, largest)),
      model_(model),
      sensors_(model),
      limits_(limits_of(model, largest, options)),
      state_(model, tip_of(options, model)),
      computed_torque_(model.joints(), joint_gains(model.joints(), options)),
      path_(model, tip_of(options, model)),
      impedance_(model, tip_of(options, model), tip_gains(options)),
      gravity_(model),
      friction_(model, options.friction),
      error_(model.joints(), {0.5 * options.frequency, options.model_error * limits_.torque}),
      safety_(model, limits_),
      rest_(without_first(rest, model.joints()), kIntegralShare * largest),
      wanted_(model.joints()),
      input_(model.joints()),
      q_(VectorXd::Zero(model.joints())),
      dq_(q_),
      off_(q_),
      tau_(q_),
      sent_(q_) {
  input_.q_wanted.setConstant(std::numeric_limits<double>::quiet_NaN());  // the run's to judge
  input_.force_expected.setConstant(std::numeric_limits<double>::quiet_NaN());
}

void ModelController::reset() noexcept {
  safety_.disable();  // a fault stays
  safety_.enable();
  safety_.activate();
  friction_.reset();
  error_.reset();
  rest_.reset();
  moves_ = false;
}

void ModelController::computed_torque(double dt) noexcept {
  off_ = wanted_.q - q_;
  tau_ = computed_torque_.update(state_, wanted_);
  tau_ += friction_.update(state_, wanted_.dq, off_, dt);
  tau_ += error_.update(state_, computed_torque_.acceleration(), dt);
}

void ModelController::impedance(double dt) noexcept {
  path_.update(wanted_.q, wanted_.dq);
  task_.x.head<3>() = path_.position();
  task_.dx.head<3>() = path_.twist().head<3>();
  task_.ddx.noalias() = path_.jacobian().lazyProduct(wanted_.ddq);
  task_.ddx.noalias() += path_.jacobian_rate().lazyProduct(wanted_.dq);
  tau_ = impedance_.update(state_, task_, Vector6d::Zero());
  tau_ += friction_.update(state_, impedance_.joint_velocity(), impedance_.joint_error(), dt);
  tau_ += error_.update(state_, impedance_.acceleration(), dt);
}

bool ModelController::torques(const BoardArmState& state, const JointReference& wanted,
                              const CycleTimes& times, VectorXd& tau) noexcept {
  const auto n = q_.size();
  q_ = state.q.head(n);
  dq_ = state.dq.head(n);
  wanted_.q = wanted.q.head(n);
  sensors_.correct_positions(q_);
  sensors_.correct_positions(wanted_.q);
  wanted_.dq = wanted.dq.head(n);
  wanted_.ddq = wanted.ddq.head(n);
  state_.update(q_, dq_);
  switch (options_.law) {
    case ControlLaw::kComputedTorque:
      computed_torque(times.dt);
      break;
    case ControlLaw::kImpedance:
      moves_ ? impedance(times.dt) : computed_torque(times.dt);
      break;
    case ControlLaw::kGravity:
      tau_ = gravity_.update(q_);
      break;
  }
  input_.dt = times.dt;
  input_.sensor_age = times.age;
  input_.sensor_age_range = times.age_range;
  const VectorXd& safe = safety_.update(state_, input_, tau_);
  if (safety_.fault() != SafetyFault::kNone) return false;
  rest_.torques(state.q, state.dq, wanted.q, wanted.dq, times.dt, tau);
  tau.head(n) = safe;
  sensors_.show_torques(tau.head(n));
  return true;
}

void ModelController::sent(const VectorXd& tau) noexcept {
  sent_ = tau.head(sent_.size());  // as the drives count
  sensors_.correct_torques(sent_);
  error_.sent(tau_, sent_);
}

std::string ModelController::why() const {
  if (safety_.fault() == SafetyFault::kNone) return "";
  const std::optional<int> joint = safety_.joint();
  return text("safety supervisor: ", describe(safety_.fault()),
              joint ? " (joint " + name_of(*joint) + ")" : "");
}

const std::string& ModelController::name_of(Eigen::Index joint) const {
  return model_.coordinates()[joint].name;
}

// Singular values are those of TaskInverse: metres count in characteristic lengths.
void ModelController::require_tip_led(const MotionSamples& motion) const {
  const Eigen::Index n = q_.size(), directions = std::min<Eigen::Index>(3, n);
  VectorXd unit = VectorXd::Constant(n, 1.0 / impedance_.inverse().length());
  for (Eigen::Index j = 0; j < n; ++j) {
    if (model_.coordinates()[j].prismatic) unit[j] = 1.0;
  }
  TipKinematics path = path_;
  VectorXd q = VectorXd::Zero(n);
  MatrixXd values(motion.rows(), directions);
  for (Eigen::Index row = 0; row < motion.rows(); ++row) {
    q = motion.q.row(row).head(n).transpose();
    path.update(q, dq_);
    const MatrixXd J = path.jacobian().topRows(3) * unit.asDiagonal();
    values.row(row) = Eigen::JacobiSVD<MatrixXd>(J).singularValues().transpose();
  }
  const double threshold = TaskInverseOptions().threshold;
  for (Eigen::Index d = 0; d < directions; ++d) {
    if (values.col(d).maxCoeff() < threshold) continue;  // never led there, as out of a plane
    Eigen::Index row = 0;
    const double least = values.col(d).minCoeff(&row);
    require(least >= threshold, "motion: leads the tip through a singular pose at ",
            motion.time[row] - motion.time[0], " s (singular value ", least, ", expected ",
            threshold, " or more); computed torque can follow there.");
  }
}

MotionLimits ModelController::limits() const {
  MotionLimits out;
  out.lower = limits_.lower;
  out.upper = limits_.upper;
  sensors_.show_positions(out.lower);
  sensors_.show_positions(out.upper);
  out.velocity = limits_.velocity;
  out.braking = limits_.braking;
  for (const Coordinate& c : model_.coordinates()) out.names.push_back(c.name);
  return out;
}

MotionSamples ModelController::as_shown(const MotionSamples& motion) const {
  MotionSamples out = motion;
  VectorXd at = VectorXd::Zero(q_.size());
  const Eigen::Index n = std::min(q_.size(), motion.joints());
  for (Eigen::Index row = 0; row < motion.rows(); ++row) {
    at.head(n) = motion.q.row(row).head(n).transpose();
    sensors_.show_positions(at);
    out.q.row(row).head(n) = at.head(n).transpose();
  }
  return out;
}

void ModelController::require_possible(const MotionSamples& motion) const {
  if (options_.law != ControlLaw::kImpedance) return;
  require(motion.joints() >= q_.size(), "motion: found ", motion.joints(), " joints, expected ",
          q_.size(), " of the model, which move the tip.");
  require_tip_led(motion);
}

}  // namespace veridyn::dvrk
