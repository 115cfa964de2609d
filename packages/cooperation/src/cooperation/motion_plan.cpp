#include "motion_plan.hpp"

#include <algorithm>
#include <cmath>

#include "veridyn/control/safety/position_limit.hpp"
#include "loop_gains.hpp"
#include "phase_commands.hpp"
#include "veridyn/control/safety_supervisor.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

using Eigen::Vector3d;

constexpr double kLookEvery = 0.004;  // [s] between two checks of the joints
constexpr double kReach = 1e-4;       // [m] largest distance of a tip from its target
constexpr double kRoomLeft = 0.0025;  // share of a joint's range that remains free, as in MotionCheck
constexpr double kJogMove = 0.1;     // [s] duration of each move of a jog

InverseKinematicsOptions reach_options() {
  InverseKinematicsOptions o;
  o.position_tolerance = 1e-6;
  return o;
}

// [m] From the start to the end of a member.
Vector3d member_vector(const CooperativeInput& seen, const ScenarioMember& m) {
  return seen.position[m.to] - seen.position[m.from];
}

std::string point_text(const Vector3d& x) { return text("(", x.x(), ", ", x.y(), ", ", x.z(), ") m"); }

}  // namespace

MotionPlan::MotionPlan(const Scenario& scenario, std::vector<PlannedArm> arms)
    : scenario_(scenario), tips_(arms.size()) {
  for (size_t k = 0; k < arms.size(); ++k) {
    const ScenarioArm& arm = scenario.arms[k];
    const veridyn::Tip tip{arm.frame, arm.offset};
    const Model& model = arms[k].model;
    const VectorXd none = VectorXd::Zero(model.joints());
    arms_.push_back({arms[k], arm.name, ArmState(model, tip), FrictionCompensation(model),
                     InverseKinematics(model, tip, reach_options()),
                     TaskInverse(model, tip, TaskRows::kPosition), none, none, none, none});
  }
  for (const ScenarioWall& wall : scenario.walls) {
    Arm& arm = arms_[wall.arm];
    arm.state.update(scenario.arms[wall.arm].start, arm.none);
    walls_.push_back(arm.known.p_world_base +
                     arm.known.R_world_base * arm.state.tip().position() + wall.point);
  }
}

MotionPlan::State MotionPlan::initial_state(const std::vector<VectorXd>& q) {
  std::vector<Vector3d> tips;
  std::vector<Eigen::Matrix3d> bases;
  for (size_t k = 0; k < arms_.size(); ++k) {
    arms_[k].state.update(q[k], arms_[k].none);
    bases.push_back(arms_[k].known.R_world_base);
    tips.push_back(arms_[k].known.p_world_base + bases[k] * arms_[k].state.tip().position());
  }
  CooperativeInput seen(static_cast<int>(tips.size()), static_cast<int>(scenario_.members.size()));
  seen.position = tips;
  State out =
      state_during_run(CooperativeController(cooperative_options(scenario_, bases), tips), seen, q);
  for (size_t k = 0; k < out.length.size(); ++k) out.length[k] += scenario_.members[k].slack;
  return out;
}

MotionPlan::State MotionPlan::state_during_run(const CooperativeController& control,
                                        const CooperativeInput& seen,
                                        const std::vector<VectorXd>& q) const {
  State out{control, seen, q, {}, {}, 0.0};
  for (size_t k = 0; k < scenario_.members.size(); ++k) {
    const ScenarioMember& m = scenario_.members[k];
    const double force = std::isfinite(seen.force[k].force) ? seen.force[k].force : 0.0;
    out.length.push_back(member_vector(seen, m).norm() - force / m.stiffness);
    out.held.push_back(1);
  }
  return out;
}

std::string MotionPlan::play(State& state, const std::vector<ScenarioCommand>& commands,
                             double seconds) {
  for (const ScenarioCommand& c : commands) {
    if (c.kind == ScenarioCommand::Kind::kForce &&
        !(std::abs(c.amount) <= scenario_.control.largest_force))
      return text("found a force of ", c.amount, " N, expected at most ",
                  scenario_.control.largest_force, " N (largest_force)");
    const auto k = static_cast<size_t>(std::max(0, c.member));
    if (c.kind == ScenarioCommand::Kind::kRelease) state.held[k] = 0;
    if (c.kind == ScenarioCommand::Kind::kTake) {
      state.held[k] = 1;
      state.length[k] = member_vector(state.seen, scenario_.members[k]).norm();
    }
    if (!apply_command(c, state.control))
      return text("the controller ", describe(state.control.state()),
                  ", still turns, or found a number that cannot be");
  }
  return advance(state, seconds);
}

std::string MotionPlan::check_command(State state, ScenarioCommand command) {
  command.over = std::min(command.over, kLongest);
  return play(state, {command}, command.over + kSettled);
}

std::string MotionPlan::jog(State state, const Vector3d& velocity, double seconds) {
  ScenarioCommand move;
  move.way = velocity * 0.5 * kJogMove;
  move.over = kJogMove;
  for (double t = 0.0; t < seconds; t += 0.5 * kJogMove) {
    const std::string why = play(state, {move}, 0.5 * kJogMove);
    if (!why.empty()) return why;
  }
  state.control.stop();
  return advance(state, kSettled);
}

// Sets the forces of members and walls at the present positions of the tips.
void MotionPlan::compute_forces(State& state) {
  for (Tip& tip : tips_) tip.force.setZero();
  for (size_t k = 0; k < scenario_.members.size(); ++k) {
    const ScenarioMember& m = scenario_.members[k];
    const auto from = static_cast<size_t>(m.from), to = static_cast<size_t>(m.to);
    const Vector3d line = member_vector(state.seen, m);
    const double length = line.norm();
    const Vector3d u = length > 0.0 ? Vector3d(line / length) : Vector3d::Zero();
    const double rate = u.dot(state.seen.velocity[to] - state.seen.velocity[from]);
    double force = m.stiffness * (length - state.length[k]) + m.damping * rate;
    if (state.held[k] == 0 || (m.pulls_only && length < state.length[k])) force = 0.0;
    ForceReading& reading = state.seen.force[k];
    reading = {force, 0.0, reading.number.value_or(-1) + 1, force};
    tips_[from].force -= force * u;
    tips_[to].force += force * u;
  }
  for (size_t k = 0; k < walls_.size(); ++k) {
    const ScenarioWall& wall = scenario_.walls[k];
    const auto arm = static_cast<size_t>(wall.arm);
    const double depth = -wall.normal.dot(state.seen.position[arm] - walls_[k]);
    const double rate = -wall.normal.dot(state.seen.velocity[arm]);
    if (depth > 0.0)
      tips_[arm].force -=
          std::max(0.0, (wall.stiffness + wall.stiffening * depth) * depth + wall.damping * rate) *
          wall.normal;
    // A sensor of one axis does not measure forces along the plane.
    if (depth > 0.0 && wall.sensor_axes == 3)
      tips_[arm].force += wall.drag * (state.seen.velocity[arm] + rate * wall.normal);
  }
}

// Advances tips by one period, exactly following their laws.
void MotionPlan::advance_tips(State& state, const std::vector<TipTarget>& targets) {
  const double dt = 1.0 / scenario_.control.rate;
  for (size_t k = 0; k < arms_.size(); ++k) {
    const bool gives = scenario_.arms[k].control == ArmControl::kImpedance;
    const ImpedanceGains g =
        gives ? impedance_gains(scenario_.control) : position_gains(scenario_.control);
    const Eigen::Matrix3d& R = arms_[k].known.R_world_base;
    const Vector3d e = R.transpose() * (targets[k].position - state.seen.position[k]);
    const Vector3d de = R.transpose() * (targets[k].velocity - state.seen.velocity[k]);
    Vector3d push = g.stiffness.head<3>().cwiseProduct(e) + g.damping.head<3>().cwiseProduct(de);
    if (gives) push -= R.transpose() * tips_[k].force;
    tips_[k].acceleration =
        targets[k].acceleration + R * push.cwiseQuotient(g.mass.head<3>());
    state.seen.velocity[k] += dt * tips_[k].acceleration;
    state.seen.position[k] += dt * state.seen.velocity[k];
  }
}

// Advances the plan by a time [s]; returns the reason for which an arm or the controller fails, or empty.
std::string MotionPlan::advance(State& state, double seconds) {
  const double rate = scenario_.control.rate;
  const long cycles = std::lround(seconds * rate);
  const long every = std::max(1L, std::lround(kLookEvery * rate));
  for (long k = 0; k < cycles; ++k, state.time += 1.0 / rate) {
    compute_forces(state);
    const std::vector<TipTarget>& targets = state.control.update(state.seen);
    if (state.control.state() != CooperativeState::kTracking) {
      std::string forces;
      for (size_t m = 0; m < state.seen.force.size(); ++m)
        forces += text(m == 0 ? ", with " : " and ", state.seen.force[m].force, " N in ",
                       scenario_.members[m].name);
      return text("at ", state.time, " s the controller ", describe(state.control.state()), forces);
    }
    advance_tips(state, targets);
    for (size_t i = 0; k % every == 0 && i < arms_.size(); ++i) {
      const std::string why = joint_violation(state, i);
      if (!why.empty()) return text("at ", state.time, " s arm ", arms_[i].name, " ", why);
    }
  }
  return "";
}

// Reason for which arm k cannot reach its tip's position, empty if it can; updates its joints.
std::string MotionPlan::joint_violation(State& state, std::size_t k) {
  Arm& arm = arms_[k];
  VectorXd& q = state.q[k];
  const Eigen::Matrix3d to_base = arm.known.R_world_base.transpose();
  const Vector3d& x = state.seen.position[k];
  if (!x.allFinite()) return "would have to come to no finite place";
  const Vector3d at = to_base * (x - arm.known.p_world_base);
  arm.inverse.solve(at, Eigen::Matrix3d::Identity(), q);
  const double short_by = arm.inverse.position_error();
  if (!(short_by <= kReach))
    return text("cannot come to ", point_text(x), ": it ends ", 1e3 * short_by,
                " mm short of it, within the limits of its joints");
  Vector6d a = Vector6d::Zero();
  arm.state.update(q, arm.none);
  arm.rates.update(arm.state.tip().jacobian());
  a.head<3>() = to_base * state.seen.velocity[k];
  arm.rates.solve(a, arm.none, arm.dq);
  arm.state.update(q, arm.dq);
  a.head<3>() = to_base * tips_[k].acceleration;
  a.head<3>() -= arm.state.tip().jacobian_rate().topRows<3>() * arm.dq;
  arm.rates.solve(a, arm.none, arm.ddq);
  arm.tau = arm.state.mass_matrix() * arm.ddq + arm.state.bias() +
            arm.state.tip().jacobian().topRows<3>().transpose() * (to_base * tips_[k].force);
  arm.friction.set_axis_states(arm.state);
  for (int i = 0; i < arm.friction.axes(); ++i) {
    const double v = arm.friction.axis(i).dot(arm.dq);
    if (v != 0.0) arm.tau += arm.friction.sliding(i, v < 0.0 ? -1.0 : 1.0, v) * arm.friction.axis(i);
  }
  const double braking = SafetyLimits().braking;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const Coordinate& c = arm.known.model.coordinates()[i];
    const char* unit = c.prismatic ? "m" : "rad";
    if (!(std::abs(arm.dq[i]) <= kSpeedShare * c.limits.velocity))
      return text("would move joint ", c.name, " with ", std::abs(arm.dq[i]), " ", unit,
                  "/s, expected at most ", kSpeedShare * c.limits.velocity, ", its tip at ", point_text(x));
    const double room = kRoomLeft * (c.limits.upper - c.limits.lower);
    if (std::isfinite(room) && leaves_range(q[i], arm.dq[i],
                                            {c.limits.lower + room, c.limits.upper - room}, braking))
      return text("would take joint ", c.name, " to ", q[i], " ", unit, " with ", arm.dq[i], " ", unit,
                  "/s, expected ", c.limits.lower, " to ", c.limits.upper,
                  " with room to stop, its tip at ", point_text(x));
    if (!(std::abs(arm.tau[i]) <= arm.known.torque[i]))
      return text("would need ", std::abs(arm.tau[i]), c.prismatic ? " N" : " N m", " at joint ", c.name,
                  ", expected at most ", arm.known.torque[i], " (acceleration ", arm.ddq[i], " ", unit,
                  "/s^2), its tip at ", point_text(x));
  }
  return "";
}

}  // namespace veridyn
