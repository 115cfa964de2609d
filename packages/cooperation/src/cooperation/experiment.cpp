#include "experiment.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "veridyn/math/eigen_pose.hpp"
#include "end_stops.hpp"
#include "loop_gains.hpp"
#include "phase_commands.hpp"
#include "cooperation/scenario/scenario_models.hpp"
#include "veridyn/simulation/sensor_noise.hpp"

namespace veridyn {
namespace {

using Eigen::Vector3d;

// (n) Encoder step of every joint [rad], [m] in a preset of sensor_noise().
VectorXd encoder_steps(const Model& model, const std::string& preset) {
  const SensorNoise noise = sensor_noise(preset);
  VectorXd out(model.joints());
  for (int i = 0; i < model.joints(); ++i) {
    out[i] = model.coordinates()[i].prismatic ? noise.encoder_step.prismatic
                                                                   : noise.encoder_step.revolute;
  }
  return out;
}

// Unit vector along a member; zero if its length is zero.
Vector3d unit_vector(const Vector3d& line) {
  const double length = line.norm();
  return length > 0.0 ? Vector3d(line / length) : Vector3d::Zero();
}

}  // namespace

Experiment::Experiment(const Scenario& scenario, const std::string& engine) : scenario_(scenario) {
  const ScenarioControl& c = scenario.control;
  if (c.force_cutoff > 0.0) smoothing_ = 1.0 - std::exp(-2.0 * M_PI * c.force_cutoff / c.rate);
  for (size_t k = 0; k < scenario.arms.size(); ++k) add_arm(k, engine);
  add_members();
  add_walls();
  make_controller();
  add_bodies();
  world_ = std::make_unique<World>(std::move(world_arms_), std::move(objects_));
  for (size_t k = 0; k < scenario.arms.size(); ++k) {
    const VectorXd& start = scenario.arms[k].start;
    world_->set_state(static_cast<int>(k), start, VectorXd::Zero(start.size()));
  }
}

void Experiment::add_arm(std::size_t index, const std::string& engine) {
  const ScenarioArm& arm = scenario_.arms[index];
  const ScenarioControl& c = scenario_.control;
  const ScenarioModels models = scenario_models(scenario_, index);
  const Eigen::Isometry3d base = Eigen::Translation3d(arm.position) * Eigen::Isometry3d(models.R_world_base);
  arms_.push_back(models.real);
  shown_.emplace_back(models.real);
  known_.emplace_back(models.known);
  measured_.push_back(arm.start);
  world_arms_.push_back({models.real, make_engine(engine, models.real), base});
  tips_.push_back({static_cast<int>(tips_.size()), *models.real.find_frame(arm.frame), arm.offset});
  TipKinematics tip(models.real, {arm.frame, arm.offset});
  tip.update(arm.start, VectorXd::Zero(arm.start.size()));
  starts_.push_back(models.p_world_base + models.R_world_base * tip.position());
  true_tips_.push_back(tip);
  ArmLoopSetup setup{models.known,
                     {arm.frame, arm.offset},
                     models.R_world_base_known,
                     models.p_world_base_known,
                     arm.control,
                     c,
                     encoder_steps(models.real, scenario_.encoder),
                     arm.start};
  loops_.emplace_back(setup);
  const double share = c.motor_lag > 0.0 ? 1.0 - std::exp(-1.0 / (c.rate * c.motor_lag)) : 1.0;
  paths_.emplace_back(arm.start.size(), share, c.torque_delay);
}

void Experiment::add_members() {
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
    member.rest_length = (starts_[to] - starts_[from]).norm() + m.slack;
    objects_.members.push_back(member);
    sensors_.emplace_back(sensor_options(scenario_, static_cast<int>(k)),
                          1.0 / scenario_.control.rate);
  }
  samples_.resize(sensors_.size());
  filtered_.assign(sensors_.size(), 0.0);
}

void Experiment::add_walls() {
  for (size_t k = 0; k < scenario_.walls.size(); ++k) {
    const ScenarioWall& w = scenario_.walls[k];
    Wall wall;
    wall.point = starts_[w.arm] + w.point;
    wall.normal = w.normal;
    wall.stiffness = w.stiffness;
    wall.stiffening = w.stiffening;
    wall.damping = w.damping;
    wall.drag = w.drag;
    wall.touches = tips_[w.arm];
    objects_.walls.push_back(wall);
    wall_sensors_.emplace_back();
    for (int channel = 0; channel < w.sensor_axes; ++channel)
      wall_sensors_.back().emplace_back(wall_sensor_options(scenario_, static_cast<int>(k), channel),
                                        1.0 / scenario_.control.rate);
  }
  walls_ = objects_.walls;
  wall_now_.resize(walls_.size());
}

void Experiment::add_bodies() {
  for (const ScenarioBody& body : scenario_.bodies) {
    const Model& first = world_arms_.front().model;
    const Vector3d gravity = base_rotation(scenario_.arms.front().turn) * first.gravity();
    held_objects_.emplace_back(body, input_->position, gravity,
                               scenario_.control.stiffness.mean());
    objects_.bodies.push_back(HeldObject::in_world(body, starts_, tips_));
  }
}

void Experiment::make_controller() {
  std::vector<Eigen::Matrix3d> bases;
  std::vector<Vector3d> tips;
  for (size_t k = 0; k < scenario_.arms.size(); ++k) {
    const ScenarioArm& arm = scenario_.arms[k];
    bases.push_back(base_rotation(arm.calibration_turn) * base_rotation(arm.turn));
    tips.push_back(loops_[k].position());
  }
  control_ = std::make_unique<CooperativeController>(cooperative_options(scenario_, bases), tips);
  input_ = std::make_unique<CooperativeInput>(static_cast<int>(tips.size()),
                                              static_cast<int>(scenario_.members.size()));
  input_->position = tips;
  limp_.assign(tips.size(), 0);
  held_.assign(scenario_.members.size(), 1);
  forces_.assign(tips.size(), Vector3d::Zero());
  targets_.resize(tips.size());
  for (size_t k = 0; k < tips.size(); ++k) {
    targets_[k].position = targets_[k].motion = tips[k];
    tau_.push_back(VectorXd::Zero(scenario_.arms[k].start.size()));
  }
}

void Experiment::begin_phase(const ScenarioPhase& phase) {
  for (const ScenarioCommand& c : phase.commands) execute(c);
}

bool Experiment::execute(const ScenarioCommand& c) {
  if (c.kind == ScenarioCommand::Kind::kRelease) {
    world_->detach(c.member);
    held_[c.member] = 0;
  }
  if (c.kind == ScenarioCommand::Kind::kTake) {
    world_->attach(c.member, world_->member(c.member).length);
    held_[c.member] = 1;
  }
  return apply_command(c, *control_);
}

// Makes arms limp or frozen whose fault has begun.
void Experiment::apply_faults() {
  for (const ScenarioFault& fault : scenario_.faults) {
    if (!fault.arm || world_->time() + 1e-9 < fault.at) continue;
    const auto k = static_cast<size_t>(*fault.arm);
    if (fault.reported) input_->healthy[k] = 0;
    if (limp_[k] != 0) continue;
    limp_[k] = fault.kind == ScenarioFault::Kind::kArmLimp ? 1 : 2;
    if (limp_[k] == 2) loops_[k].freeze();
  }
}

// Measures the arms, and samples, filters and stores the forces of all members and walls.
void Experiment::read_sensors() {
  const double now = world_->time();
  std::fill(forces_.begin(), forces_.end(), Vector3d::Zero());
  for (size_t k = 0; k < loops_.size(); ++k) {
    measured_[k] = world_->q(static_cast<int>(k));
    shown_[k].add_position_errors(measured_[k]);
    known_[k].correct_positions(measured_[k]);
    loops_[k].measure(measured_[k]);
    input_->position[k] = loops_[k].position();
    input_->velocity[k] = loops_[k].velocity();
  }
  for (size_t k = 0; k < sensors_.size(); ++k) {
    samples_[k] = sensors_[k].read(now, world_->member(static_cast<int>(k)).tension);
    const ForceSample& sample = samples_[k];
    filtered_[k] += smoothing_ * (sample.force - filtered_[k]);
    input_->force[k] = {filtered_[k], now - sample.time, sample.number, sample.force};
    const ScenarioMember& m = scenario_.members[k];
    const auto from = static_cast<size_t>(m.from);
    const auto to = static_cast<size_t>(m.to);
    const Vector3d u = unit_vector(input_->position[to] - input_->position[from]);
    forces_[from] -= filtered_[k] * u;
    forces_[to] += filtered_[k] * u;
  }
  read_contacts(now);
}

// Computes the forces of walls on the tips, and gives the measured forces on walls and held bodies to the
// loops.
void Experiment::read_contacts(double now) {
  for (size_t k = 0; k < walls_.size(); ++k) {
    Contact& contact = wall_now_[k];
    const World::PointMotion tip = world_->point(walls_[k].touches);
    contact.rate = -walls_[k].normal.dot(tip.velocity);
    contact.force = walls_[k].normal.dot(contact_force(walls_[k], tip.position, tip.velocity));
    const Vector3d truth = wall_channels_now(static_cast<int>(k));
    Vector3d channels = Vector3d::Zero();
    for (size_t c = 0; c < wall_sensors_[k].size(); ++c) {
      const auto axis = static_cast<Eigen::Index>(c);
      channels[axis] = wall_sensors_[k][c].read(now, truth[axis]).force;
    }
    contact.filtered += smoothing_ * (channels - contact.filtered);
    const int arm = scenario_.walls[k].arm;
    const Eigen::Matrix3d R_world_tip = loops_[arm].rotation();
    contact.measured = force_of_channels(scenario_.walls[k], channels, R_world_tip);
    forces_[arm] -= force_of_channels(scenario_.walls[k], contact.filtered, R_world_tip);
  }
  for (size_t b = 0; b < held_objects_.size(); ++b) {
    const std::vector<ScenarioBody::Grasp>& grasps = held_objects_[b].scenario().grasps;
    for (size_t g = 0; g < grasps.size(); ++g)
      forces_[grasps[g].arm] -=
          world_->grasp_force(static_cast<int>(b), static_cast<int>(g));
  }
}

Vector3d Experiment::wall_channels_now(int wall) {
  const Wall& w = walls_[wall];
  const World::PointMotion tip = world_->point(w.touches);
  const int arm = scenario_.walls[wall].arm;
  TipKinematics& axes = true_tips_[arm];
  if (scenario_.walls[wall].sensor_axes == 3) axes.update(world_->q(arm), world_->dq(arm));
  return wall_channels(scenario_.walls[wall], contact_force(w, tip.position, tip.velocity),
                       base_rotation(scenario_.arms[arm].turn) * axes.rotation());
}

bool Experiment::step() {
  apply_faults();
  read_sensors();
  targets_ = control_->update(*input_);
  for (HeldObject& object : held_objects_) object.update(*control_, *input_, targets_);
  // An impedance whose desired mass is below the arm's needs the measured force: without a sensor all arms hold
  // their positions, as they do if the target has come to rest away from the tip.
  if (control_->sensor_failed() || control_->state() == CooperativeState::kTargetMissed) {
    for (ArmLoop& loop : loops_) loop.freeze();
  }
  const bool guards = scenario_.control.guard && !control_->sensor_failed() &&
                      control_->state() != CooperativeState::kTracking;
  for (size_t k = 0; k < loops_.size(); ++k) {
    if (guards) loops_[k].hold_within(control_->relief_force(), forces_[k]);
    tau_[k] = paths_[k].update(loops_[k].torque(targets_[k], forces_[k]));
    known_[k].add_torque_errors(tau_[k]);
    shown_[k].correct_torques(tau_[k]);
    if (limp_[k] == 1) tau_[k].setZero();
  }
  status_ = world_->step(tau_, 1.0 / scenario_.control.rate);
  for (size_t k = 0; k < limp_.size(); ++k) {
    if (limp_[k] == 1) stop_at_ends(*world_, arms_[k], static_cast<int>(k));
  }
  if (status_ == StepStatus::kOk && is_out_of_range()) status_ = StepStatus::kRanAway;
  return status_ == StepStatus::kOk;
}

// True if the simulation has diverged: a joint has left its range by more than the range itself, or an arm
// moves too fast.
bool Experiment::is_out_of_range() const {
  for (int k = 0; k < world_->arms(); ++k) {
    if (limp_[k] == 1) continue;  // the scenario itself lets this arm fall
    const std::vector<Coordinate>& joints = arms_[k].coordinates();
    for (size_t i = 0; i < joints.size(); ++i) {
      const Limits& limits = joints[i].limits;
      const double q = world_->q(k)[static_cast<Eigen::Index>(i)];
      const double range = limits.upper - limits.lower;
      if (std::isfinite(range) && (q > limits.upper + range || q < limits.lower - range))
        return true;
    }
  }
  return false;
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
  for (size_t i = 0; i < walls_.size(); ++i) {
    MemberTrace& trace = run.member[sensors_.size() + i];
    trace.force[k] = wall_now_[i].force;
    trace.rate[k] = wall_now_[i].rate;
    trace.measured[k] = wall_now_[i].measured.dot(walls_[i].normal);
    if (trace.axes.rows() > 0) trace.axes.row(k) = wall_now_[i].measured.transpose();
  }
  for (size_t i = 0; i < held_objects_.size(); ++i) {
    run.body[i].position.row(k) = world_->body(static_cast<int>(i)).position.transpose();
    run.body[i].wanted.row(k) = held_objects_[i].wanted().transpose();
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
