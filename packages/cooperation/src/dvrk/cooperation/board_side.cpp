#include "board_side.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

constexpr double kForceFactor = 1.5;      // factor on the controller's bound for the supervisor's bound
constexpr double kAgeFactor = 10.0;       // factor on the controller's bound, so that the controller stops first
constexpr double kOverrun = 0.05;         // [s] longest cycle that the supervisor accepts
constexpr double kSensorAge = 0.02;       // [s] largest age of positions
constexpr double kSaturatedSeconds = 0.5;
constexpr double kStall = 0.6;            // [s] longer stall: the supervisor holds the arm before its boards switch it off
constexpr int kStarts = 20;

ArmSessionOptions options_of(const Scenario& scenario, const CooperatingArm& arm,
                             const BoardCooperationOptions& options) {
  ArmSessionOptions o;
  o.actuator_to_joint = arm.coupling;
  o.rate = scenario.control.rate;
  o.watchdog = options.watchdog;
  o.reply_timeout = options.reply_timeout;
  o.follow = options.checks.follow;
  o.stall = kStall;
  return o;
}

}  // namespace

BoardSide::BoardSide(const Scenario& scenario, std::size_t index, const CooperatingArm& arm,
                     const BoardCooperationOptions& options, std::unique_ptr<DatagramLink> link)
    : models_(scenario_models(scenario, index)),
      link_(std::move(link)),
      session_(*link_, arm.robot, options_of(scenario, arm, options)),
      sensors_(models_.known),
      joints_(models_.known.joints()),
      q_(VectorXd::Zero(joints_)),
      dq_(q_),
      tau_(q_),
      rest_(q_),
      all_(VectorXd::Zero(session_.joints())),
      state_(models_.known, {scenario.arms[index].frame, scenario.arms[index].offset}),
      touch_(models_.known, {scenario.arms[index].frame, scenario.arms[index].offset}),
      input_(joints_),
      checks_(options.checks) {
  require(joints_ <= session_.joints(), "arm '", scenario.arms[index].name, "': found a model of ",
          joints_, " joints, but boards for ", session_.joints(), ".");
  // Emulated boards share the machine with this program, and answer late if it is busy.
  for (int left = options.emulate ? kStarts : 1;;) {
    try {
      session_.start();
      return;
    } catch (const InvalidInput&) {
      if (--left == 0) throw;
    }
  }
}

void BoardSide::begin(const Scenario& scenario, std::size_t index) {
  const ScenarioArm& arm = scenario.arms[index];
  require(session_.state().q.allFinite(), "arm '", arm.name,
          "': found no position, expected its boards to answer.");
  q_ = session_.state().q.head(joints_);
  sensors_.correct_positions(q_);
  loop_.emplace(ArmLoopSetup{models_.known,
                             {arm.frame, arm.offset},
                             models_.R_world_base_known,
                             models_.p_world_base_known,
                             arm.control,
                             scenario.control,
                             VectorXd::Zero(joints_),
                             q_});
  SafetyLimits limits = safety_limits(models_.known, 1.0);
  limits.torque = largest_torque();
  limits.force = kForceFactor * scenario.control.largest_force;
  limits.force_age = kAgeFactor * scenario.control.largest_age;
  limits.overrun = kOverrun;
  limits.sensor_age = kSensorAge;
  limits.resolution = session_.units().joint_steps().head(joints_);
  limits.torque_seconds = kSaturatedSeconds;
  limits.force_disagreement = checks_.force_disagreement;
  limits.disagreement_seconds = checks_.disagreement_seconds;
  velocity_ = limits.velocity;
  supervisor_ = std::make_unique<SafetySupervisor>(models_.known, limits);
  supervisor_->enable();
  supervisor_->activate();
  told_ = 0;
  acted_.reset();
  input_.q_wanted.setConstant(std::numeric_limits<double>::quiet_NaN());
  input_.force_expected.setConstant(std::numeric_limits<double>::quiet_NaN());
}

VectorXd BoardSide::largest_torque() const {
  VectorXd out(joints_);
  for (int i = 0; i < joints_; ++i) {
    const ActuatorConfig& a = session_.robot().actuators[i];
    out[i] = std::abs(a.max_current / a.effort_to_amps);
  }
  out = sensors_.largest_true_torques(out);
  for (int i = 0; i < joints_; ++i)
    out[i] = std::min(out[i], models_.known.coordinates()[i].limits.effort);
  return out;
}

void BoardSide::read(double now) noexcept {
  now_ = now;
  valid_ = !deaf_ && session_.update();
  if (!valid_) return;
  heard_ = now;
  q_ = session_.state().q.head(joints_);
  sensors_.correct_positions(q_);
  dq_ = session_.state().dq.head(joints_);
  if (loop_) loop_->measure(q_);
}

void BoardSide::act(const TipTarget& target, const Eigen::Vector3d& exerted, double age,
                    double dt) noexcept {
  if (!valid_ || !session_.ready()) return;
  state_.update(q_, dq_);
  touch_.update(state_, tau_, rest_, dt);
  if (compares_) input_.force_expected = touch_.force();
  const VectorXd& wanted = loop_->torque(target, exerted);
  supervisor_->set_holding_torque(loop_->extra_torque());
  drive(wanted, exerted, age, dt);
  loop_->set_sent_torques(tau_);
}

void BoardSide::drive(const VectorXd& wanted, const Eigen::Vector3d& exerted, double age,
                      double dt) noexcept {
  if (!valid_ || !session_.ready()) return;
  state_.update(q_, dq_);
  const double now = link_->now();
  input_.dt = acted_ ? now - *acted_ : dt;
  const BoardBus::Interval measured = session_.boards().bus().measured();
  input_.sensor_age = now - measured.from;
  input_.sensor_age_range = measured.to - measured.from;
  acted_ = now;
  input_.force.noalias() = models_.R_world_base_known.transpose() * exerted;
  input_.force_age = age;
  tau_ = supervisor_->update(state_, input_, wanted);
  if (supervisor_->action() == SafetyAction::kMotorsOff && !cut_) {
    cut_ = true;
    session_.power_off();  // removes power, so that brakes engage where the arm has them
  }
  all_.head(joints_) = tau_;
  sensors_.add_torque_errors(all_.head(joints_));
  session_.set_torques(all_);
  tau_ = session_.command().tau.head(joints_);
  sensors_.correct_torques(tau_);
}

BoardSide::News BoardSide::poll_faults(double largest_age) noexcept {
  const bool off = session_.boards().state() == PowerState::kFault;
  // Boards that do not answer delay the others; the switch-off is sent nevertheless.
  if (now_ - heard_ > largest_age && !reported_silence_) {
    reported_silence_ = true;
    deaf_ = !valid_;
    return {"its boards do not answer"};
  }
  if (off && !told_off_) {
    told_off_ = true;
    deaf_ = !valid_;
    return {describe(session_.boards().cause())};
  }
  if (told_ >= supervisor_->events()) return {};
  const SafetyEvent& event = supervisor_->event(told_++);
  const bool of_force = event.fault == SafetyFault::kForceSensor;
  const bool unexplained = of_force && unexplained_force() > checks_.force_disagreement;
  return {describe(event.fault), event.joint, unexplained, of_force && !unexplained};
}

}  // namespace veridyn::dvrk
