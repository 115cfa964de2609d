#include "dvrk/run/controllers/model_controller.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

// Returns the options; throws InvalidInput if they do not fit the model or the arm.
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

// Options of the cycle with limits in true torques; `largest` (n of the arm) in the scale of the drives.
CycleOptions cycle_of(const Model& model, const VectorXd& largest, const ModelControlOptions& options) {
  const VectorXd most = JointSensors(model).largest_true_torques(largest.head(model.joints()));
  SafetyLimits limits = safety_limits(model, most.maxCoeff());
  limits.torque = limits.torque.cwiseMin(most);
  limits.sensor_age = limits.overrun = options.longest_gap;
  if (options.position_steps.size() > 0) limits.resolution = options.position_steps.head(model.joints());
  CycleOptions out;
  out.friction = options.friction;
  out.error_bandwidth = 0.5 * options.frequency;
  out.error_limit = options.model_error * limits.torque;
  out.limits = limits;
  return out;
}

// The user's gains, or those of two equal poles at options.frequency.
JointGains joint_gains(int joints, const ModelControlOptions& options) {
  if (options.joint_gains) return *options.joint_gains;
  const double frequency = options.frequency;
  return {VectorXd::Constant(joints, frequency * frequency),
          VectorXd::Constant(joints, 2.0 * frequency)};
}

// The user's gains, or critical damping of tip_mass and stiffness in all directions.
ImpedanceGains tip_gains(const ModelControlOptions& options) {
  if (options.tip_gains) return *options.tip_gains;
  ImpedanceGains gains;
  gains.mass.setConstant(options.tip_mass);
  gains.stiffness.setConstant(options.stiffness);
  gains.damping.setConstant(2.0 * std::sqrt(options.tip_mass * options.stiffness));
  return gains;
}

// The gains with zeros for the first joints.
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
      cycle_(model, tip_of(options, model), cycle_of(model, largest, options)),
      computed_torque_(model.joints(), joint_gains(model.joints(), options)),
      path_(model, tip_of(options, model)),
      impedance_(model, tip_of(options, model), tip_gains(options)),
      gravity_(model),
      rest_(without_first(rest, model.joints()), {kIntegralShare * largest, {}}),
      measured_(model.joints()),
      wanted_(model.joints()),
      off_(VectorXd::Zero(model.joints())),
      sent_(off_) {
  measured_.dq = off_;
}

void ModelController::reset() noexcept {
  cycle_.reset_observers();
  rest_.reset();
  moves_ = false;
}

void ModelController::computed_torque() noexcept {
  off_ = wanted_.q - cycle_.state().q();
  cycle_.command(computed_torque_.update(cycle_.state(), wanted_));
  cycle_.add_friction(wanted_.dq, off_);
  cycle_.add_model_error(computed_torque_.acceleration());
}

void ModelController::impedance() noexcept {
  path_.update(wanted_.q, wanted_.dq);
  task_.x.head<3>() = path_.position();
  task_.dx.head<3>() = path_.twist().head<3>();
  task_.ddx.noalias() = path_.jacobian().lazyProduct(wanted_.ddq);
  task_.ddx.noalias() += path_.jacobian_rate().lazyProduct(wanted_.dq);
  cycle_.command(impedance_.update(cycle_.state(), task_, Vector6d::Zero()));
  cycle_.add_friction(impedance_.joint_velocity(), impedance_.joint_error());
  cycle_.add_model_error(impedance_.acceleration());
}

bool ModelController::torques(const BoardArmState& state, const JointReference& wanted,
                              const CycleTimes& times, VectorXd& tau) noexcept {
  const auto n = off_.size();
  measured_.q = state.q.head(n);
  measured_.dq = state.dq.head(n);
  measured_.age = times.age;
  measured_.age_range = times.age_range;
  wanted_.q = wanted.q.head(n);
  cycle_.sensors().correct_positions(wanted_.q);
  wanted_.dq = wanted.dq.head(n);
  wanted_.ddq = wanted.ddq.head(n);
  cycle_.measure(measured_, times.dt);  // without set points: the run checks tracking errors
  switch (options_.law) {
    case ControlLaw::kComputedTorque:
      computed_torque();
      break;
    case ControlLaw::kImpedance:
      moves_ ? impedance() : computed_torque();
      break;
    case ControlLaw::kGravity:
      cycle_.command(gravity_.update(cycle_.state().q()));
      break;
  }
  const VectorXd& safe = cycle_.send();
  if (cycle_.fault()) return false;
  rest_.torques(state.q, state.dq, wanted.q, wanted.dq, times.dt, tau);
  tau.head(n) = safe;
  return true;
}

void ModelController::set_sent_torques(const VectorXd& tau) noexcept {
  sent_ = tau.head(sent_.size());
  cycle_.set_sent_torques(sent_);
}

std::string ModelController::refusal_reason() const {
  const std::optional<ControllerFault> fault = cycle_.fault();
  if (!fault) return "";
  return text("safety supervisor: ", describe(fault->what),
              fault->joint ? " (joint " + model_.coordinates()[fault->joint->value].name + ")" : "");
}

// Singular values are those of TaskInverse: metres are divided by the characteristic length.
void ModelController::require_tip_led(const MotionSamples& motion) const {
  const Eigen::Index n = off_.size(), directions = std::min<Eigen::Index>(3, n);
  VectorXd unit = VectorXd::Constant(n, 1.0 / impedance_.inverse().length());
  for (Eigen::Index j = 0; j < n; ++j) {
    if (model_.coordinates()[j].prismatic) unit[j] = 1.0;
  }
  TipKinematics path = path_;
  VectorXd q = VectorXd::Zero(n);
  MatrixXd values(motion.rows(), directions);
  for (Eigen::Index row = 0; row < motion.rows(); ++row) {
    q = motion.q.row(row).head(n).transpose();
    path.update(q, VectorXd::Zero(n));
    const MatrixXd J = path.jacobian().topRows(3) * unit.asDiagonal();
    values.row(row) = Eigen::JacobiSVD<MatrixXd>(J).singularValues().transpose();
  }
  const double threshold = TaskInverseOptions().threshold;
  for (Eigen::Index d = 0; d < directions; ++d) {
    if (values.col(d).maxCoeff() < threshold) continue;  // the arm never moves in this direction, for example perpendicular to its plane
    Eigen::Index row = 0;
    const double least = values.col(d).minCoeff(&row);
    require(least >= threshold, "motion: leads the tip through a singular pose at ",
            motion.time[row] - motion.time[0], " s (singular value ", least, ", expected ",
            threshold, " or more); computed torque can follow there.");
  }
}

MotionLimits ModelController::limits() const {
  MotionLimits out;
  const SafetyLimits& limits = cycle_.limits();
  out.lower = limits.lower;
  out.upper = limits.upper;
  sensors().add_position_errors(out.lower);
  sensors().add_position_errors(out.upper);
  out.velocity = limits.velocity;
  out.braking = limits.braking;
  for (const Coordinate& c : model_.coordinates()) out.names.push_back(c.name);
  return out;
}

MotionSamples ModelController::to_board_positions(const MotionSamples& motion) const {
  MotionSamples out = motion;
  VectorXd at = VectorXd::Zero(off_.size());
  const Eigen::Index n = std::min(off_.size(), motion.joints());
  for (Eigen::Index row = 0; row < motion.rows(); ++row) {
    at.head(n) = motion.q.row(row).head(n).transpose();
    sensors().add_position_errors(at);
    out.q.row(row).head(n) = at.head(n).transpose();
  }
  return out;
}

void ModelController::require_possible(const MotionSamples& motion) const {
  if (options_.law != ControlLaw::kImpedance) return;
  require(motion.joints() >= off_.size(), "motion: found ", motion.joints(), " joints, expected ",
          off_.size(), " of the model, which move the tip.");
  require_tip_led(motion);
}

}  // namespace veridyn::dvrk
