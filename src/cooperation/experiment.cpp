#include "experiment.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "model_errors.hpp"
#include "scenario_parts.hpp"
#include "veridyn/kinematics/kinematics.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/model/model_file.hpp"
#include "veridyn/simulation/plausible_model.hpp"
#include "veridyn/simulation/sensor_noise.hpp"

namespace veridyn {
namespace {

using Eigen::Vector3d;

Mat3d rotation(const Vector3d& turn) {
  return rotation_z(turn.z()) * rotation_y(turn.y()) * rotation_x(turn.x());
}

Eigen::Matrix3d eigen(const Mat3d& R) {
  Eigen::Matrix3d out;
  // clang-format off
  out << R.row0.x, R.row0.y, R.row0.z,
         R.row1.x, R.row1.y, R.row1.z,
         R.row2.x, R.row2.y, R.row2.z;
  // clang-format on
  return out;
}

// With gravity as the turned base feels it.
Model true_arm(const ScenarioArm& arm, const Eigen::Matrix3d& R_world_base) {
  ModelDescription description = read_model(arm.model).description();
  description.gravity = R_world_base.transpose() * description.gravity;
  return plausible_model(Model(std::move(description)), arm.seed).arm;
}

VectorXd encoder_steps(const Model& model, const std::string& preset) {
  const SensorNoise noise = sensor_noise(preset);
  VectorXd out(model.joints());
  for (int i = 0; i < model.joints(); ++i) {
    out[i] = model.coordinates()[static_cast<size_t>(i)].prismatic ? noise.encoder_step.prismatic
                                                                   : noise.encoder_step.revolute;
  }
  return out;
}

}  // namespace

Experiment::Experiment(const Scenario& scenario, const std::string& engine) : scenario_(scenario) {
  for (size_t k = 0; k < scenario.arms.size(); ++k)
    add_arm(scenario.arms[k], engine, scenario.seed + static_cast<unsigned>(k));
  add_members();
  CooperativeOptions o;
  std::vector<Vector3d> tips;
  for (size_t k = 0; k < scenario.arms.size(); ++k) {
    o.R_world_arm.push_back(eigen(rotation(scenario.arms[k].turn)));
    tips.push_back(loops_[k].position());
  }
  const ScenarioControl& c = scenario.control;
  o.master = scenario.master;
  for (const ScenarioMember& m : scenario.members) {
    const bool stiff =
        scenario.arms[static_cast<size_t>(m.from)].control == ArmControl::kPosition &&
        scenario.arms[static_cast<size_t>(m.to)].control == ArmControl::kPosition;
    o.members.push_back({m.from, m.to, m.law, stiff ? 0.5 : 1.0});
  }
  o.period = 1.0 / c.rate;
  o.largest_force = c.largest_force;
  o.largest_force_error = c.largest_force_error;
  o.largest_age = c.largest_age;
  o.largest_error = c.largest_error;
  o.stuck_force = c.stuck_force;
  control_ = std::make_unique<CooperativeController>(o, tips);
  input_ = std::make_unique<CooperativeInput>(static_cast<int>(tips.size()),
                                              static_cast<int>(scenario.members.size()));
  limp_.assign(tips.size(), 0);
  held_.assign(scenario.members.size(), 1);
  forces_.assign(tips.size(), Vector3d::Zero());
  targets_.resize(tips.size());
  for (size_t k = 0; k < tips.size(); ++k) {
    targets_[k].position = targets_[k].motion = tips[k];
    tau_.push_back(VectorXd::Zero(scenario.arms[k].start.size()));
  }
}

void Experiment::add_arm(const ScenarioArm& arm, const std::string& engine, unsigned seed) {
  const Mat3d R = rotation(arm.turn);
  const Model model = true_arm(arm, eigen(R));
  check_arm(arm, model);
  const Posed base{R, {arm.position.x(), arm.position.y(), arm.position.z()}};
  world_arms_.push_back({model, make_engine(engine, model), base});
  tips_.push_back({static_cast<int>(tips_.size()), model.find_frame(arm.frame), arm.offset});
  ArmLoopSetup setup{with_parameter_errors(model, scenario_.model_error, seed),
                     {arm.frame, arm.offset},
                     eigen(R),
                     arm.position,
                     arm.control,
                     scenario_.control,
                     encoder_steps(model, scenario_.encoder),
                     arm.start};
  loops_.emplace_back(setup);
}

void Experiment::add_members() {
  WorldObjects objects;
  for (size_t k = 0; k < scenario_.members.size(); ++k) {
    const ScenarioMember& m = scenario_.members[k];
    const auto from = static_cast<size_t>(m.from);
    const auto to = static_cast<size_t>(m.to);
    Member member;
    member.name = m.name;
    member.from = tips_[from];
    member.to = tips_[to];
    member.stiffness = m.stiffness;
    member.damping = m.damping;
    member.pulls_only = m.pulls_only;
    member.rest_length = (loops_[to].position() - loops_[from].position()).norm() + m.slack;
    objects.members.push_back(member);
    ForceSensorOptions sensor = m.sensor;
    sensor.seed = scenario_.seed + 1000 + static_cast<unsigned>(k);
    for (const ScenarioFault& fault : scenario_.faults) {
      if (fault.member != static_cast<int>(k)) continue;
      if (fault.kind == ScenarioFault::Kind::kSensorStuck) sensor.stuck_from = fault.at;
      if (fault.kind == ScenarioFault::Kind::kSensorStale) sensor.stale_from = fault.at;
    }
    sensors_.emplace_back(sensor, 1.0 / scenario_.control.rate);
  }
  samples_.resize(sensors_.size());
  world_ = std::make_unique<World>(std::move(world_arms_), std::move(objects));
  for (size_t k = 0; k < scenario_.arms.size(); ++k) {
    const VectorXd& start = scenario_.arms[k].start;
    world_->set_state(static_cast<int>(k), start, VectorXd::Zero(start.size()));
  }
}

void Experiment::begin(const ScenarioPhase& phase) {
  for (const ScenarioCommand& c : phase.commands) command(c);
}

void Experiment::command(const ScenarioCommand& c) {
  switch (c.kind) {
    case ScenarioCommand::Kind::kMove:
      control_->move(c.way, c.over);
      return;
    case ScenarioCommand::Kind::kTurn:
      control_->turn(c.way, c.over);
      return;
    case ScenarioCommand::Kind::kTighten:
      control_->tighten(c.amount, c.over);
      return;
    case ScenarioCommand::Kind::kForce:
      control_->set_force(c.member, c.amount, c.over);
      return;
    case ScenarioCommand::Kind::kMoveArm:
      control_->move_arm(c.arm, c.way, c.over);
      return;
    case ScenarioCommand::Kind::kRelease:
      world_->detach(c.member);
      control_->track(c.member, false);
      held_[static_cast<size_t>(c.member)] = 0;
      return;
    case ScenarioCommand::Kind::kTake:
      world_->attach(c.member, world_->member(c.member).length);
      control_->track(c.member, true);
      held_[static_cast<size_t>(c.member)] = 1;
      return;
  }
}

void Experiment::apply_faults() {
  for (const ScenarioFault& fault : scenario_.faults) {
    if (fault.arm < 0 || world_->time() + 1e-9 < fault.at) continue;
    const auto k = static_cast<size_t>(fault.arm);
    if (fault.reported) input_->healthy[k] = 0;
    if (limp_[k] != 0) continue;
    limp_[k] = fault.kind == ScenarioFault::Kind::kArmLimp ? 1 : 2;
    if (limp_[k] == 2) loops_[k].freeze();
  }
}

void Experiment::read_sensors() {
  const double now = world_->time();
  std::fill(forces_.begin(), forces_.end(), Vector3d::Zero());
  for (size_t k = 0; k < loops_.size(); ++k) {
    loops_[k].measure(world_->q(static_cast<int>(k)));
    input_->position[k] = loops_[k].position();
    input_->velocity[k] = loops_[k].velocity();
  }
  for (size_t k = 0; k < sensors_.size(); ++k) {
    samples_[k] = sensors_[k].read(now, world_->member(static_cast<int>(k)).tension);
    const ForceSample& sample = samples_[k];
    input_->force[k] = {sample.force, now - sample.time, sample.number};
    const ScenarioMember& m = scenario_.members[k];
    const auto from = static_cast<size_t>(m.from);
    const auto to = static_cast<size_t>(m.to);
    const Vector3d u = (input_->position[to] - input_->position[from]).normalized();
    forces_[from] -= sample.force * u;
    forces_[to] += sample.force * u;
  }
}

bool Experiment::step() {
  apply_faults();
  read_sensors();
  targets_ = control_->update(*input_);
  // An impedance that is lighter than its arm needs the force: without a sensor all stand still.
  if (control_->sensor_failed()) {
    for (ArmLoop& loop : loops_) loop.freeze();
  }
  for (size_t k = 0; k < loops_.size(); ++k) {
    tau_[k] = loops_[k].torque(targets_[k], forces_[k]);
    if (limp_[k] == 1) tau_[k].setZero();
  }
  status_ = world_->step(tau_, 1.0 / scenario_.control.rate);
  return status_ == StepStatus::kOk;
}

void Experiment::record(ScenarioRun& run, Eigen::Index k) const {
  run.time[k] = world_->time();
  for (size_t i = 0; i < loops_.size(); ++i) {
    const auto arm = static_cast<int>(i);
    ArmTrace& trace = run.arm[i];
    trace.q.row(k) = world_->q(arm).transpose();
    trace.dq.row(k) = world_->dq(arm).transpose();
    trace.tau.row(k) = tau_[i].transpose();
    trace.tip.row(k) = world_->point(tips_[i]).position.transpose();
    trace.motion.row(k) = targets_[i].motion.transpose();
    trace.target.row(k) = targets_[i].position.transpose();
  }
  for (size_t i = 0; i < sensors_.size(); ++i) {
    const auto member = static_cast<int>(i);
    MemberTrace& trace = run.member[i];
    const World::MemberState& now = world_->member(member);
    trace.wanted[k] = held_[i] != 0 ? control_->wanted_force(member) : 0.0;
    trace.force[k] = now.tension;
    trace.rate[k] = now.rate;
    trace.measured[k] = samples_[i].force;
    trace.x_f[k] = control_->correction(member);
    trace.tracked[k] = held_[i];
  }
}

std::vector<std::string> Experiment::left_out() const {
  std::vector<std::string> out;
  for (int k = 0; k < world_->arms(); ++k) {
    for (const std::string& one : world_->engine(k).left_out()) {
      if (std::find(out.begin(), out.end(), one) == out.end()) out.push_back(one);
    }
  }
  return out;
}

}  // namespace veridyn
