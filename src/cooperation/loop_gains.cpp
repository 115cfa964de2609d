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
    return scenario.arms[static_cast<size_t>(arm)].control == ArmControl::kPosition;
  };
  return is_stiff(member.from) && is_stiff(member.to) ? 0.5 : 1.0;
}

}  // namespace veridyn
