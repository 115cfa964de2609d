#include "loop_gains.hpp"

#include <cmath>

namespace veridyn {
namespace {

ImpedanceGains gains(const Eigen::Vector3d& m, const Eigen::Vector3d& d, const Eigen::Vector3d& k) {
  ImpedanceGains g;
  g.mass.head<3>() = m;
  g.damping.head<3>() = d;
  g.stiffness.head<3>() = k;
  return g;
}

}  // namespace

ImpedanceGains impedance_gains(const ScenarioControl& control) {
  return gains(control.mass, control.damping, control.stiffness);
}

ImpedanceGains position_gains(const ScenarioControl& control) {
  const double omega = 2.0 * M_PI * control.position_frequency;
  const Eigen::Vector3d one = Eigen::Vector3d::Ones();
  return gains(one, 2.0 * omega * one, omega * omega * one);
}

double member_share(const Scenario& scenario, const ScenarioMember& member) {
  const auto is_stiff = [&](int arm) {
    return scenario.arms[arm].control == ArmControl::kPosition;
  };
  return is_stiff(member.from) && is_stiff(member.to) ? 0.5 : 1.0;
}

CooperativeOptions cooperative_options(const Scenario& scenario,
                                       const std::vector<Eigen::Matrix3d>& R_world_arm) {
  const ScenarioControl& c = scenario.control;
  CooperativeOptions o;
  o.R_world_arm = R_world_arm;
  o.leader = scenario.master;
  for (const ScenarioMember& m : scenario.members)
    o.members.push_back({m.from, m.to, m.law, member_share(scenario, m)});
  o.period = 1.0 / c.rate;
  o.largest_force = c.largest_force;
  o.largest_force_error = c.largest_force_error;
  o.largest_age = c.largest_age;
  o.largest_error = c.largest_error;
  o.stuck_force = c.stuck_force;
  o.jump_force = c.jump_force;
  o.drift_force = c.drift_force;
  if (c.largest_energy > 0.0) o.largest_energy = c.largest_energy;
  o.relief_force = c.relief_force;
  o.guard = c.guard;
  return o;
}

ForceSensorOptions sensor_options(const Scenario& scenario, int member) {
  ForceSensorOptions sensor = scenario.members[member].sensor;
  sensor.seed = scenario.seed + 1000 + static_cast<unsigned>(member);
  for (const ScenarioFault& fault : scenario.faults) {
    if (fault.member != member) continue;
    if (fault.kind == ScenarioFault::Kind::kSensorStuck) sensor.stuck_from = fault.at;
    if (fault.kind == ScenarioFault::Kind::kSensorStale) sensor.stale_from = fault.at;
    const bool jumps = fault.kind == ScenarioFault::Kind::kSensorJump;
    if (!jumps && fault.kind != ScenarioFault::Kind::kSensorDrift) continue;
    sensor.jump_from = fault.at;
    (jumps ? sensor.jump_by : sensor.drift) = fault.by;
  }
  return sensor;
}

ForceSensorOptions wall_sensor_options(const Scenario& scenario, int wall, int channel) {
  ForceSensorOptions sensor = scenario.walls[wall].sensor;
  sensor.seed = scenario.seed + 2000 + static_cast<unsigned>(wall + 1000 * channel);
  return sensor;
}

Eigen::Vector3d wall_channels(const ScenarioWall& wall, const Eigen::Vector3d& force,
                              const Eigen::Matrix3d& R_world_tip) noexcept {
  if (wall.sensor_axes == 1) return {force.dot(wall.normal), 0.0, 0.0};
  return R_world_tip.transpose() * force;
}

Eigen::Vector3d force_of_channels(const ScenarioWall& wall, const Eigen::Vector3d& channels,
                                  const Eigen::Matrix3d& R_world_tip) noexcept {
  if (wall.sensor_axes == 1) return channels[0] * wall.normal;
  return R_world_tip * channels;
}

}  // namespace veridyn
