#pragma once

#include "veridyn/control/cooperative_controller.hpp"
#include "veridyn/control/impedance.hpp"
#include "veridyn/cooperation/scenario.hpp"

namespace veridyn {

// Gains of a scenario's loops, shared by the loops and their linearisation.

constexpr double kPostureStiffness = 25.0;  ///< [1/s^2] stiffness in the null space of the task
constexpr double kPostureDamping = 10.0;    ///< [1/s]

/// Gains of the scenario's impedances, in the axes of the base.
ImpedanceGains impedance_gains(const ScenarioControl& control);
/// Gains of a position loop: unit mass, so that they are independent of the arm's mass.
ImpedanceGains position_gains(const ScenarioControl& control);

/// CooperativeMember::share of a member: 1/2 where both ends are position loops.
double member_share(const Scenario& scenario, const ScenarioMember& member);

/// @param R_world_arm  axes of the arms' bases as known to the controller.
CooperativeOptions cooperative_options(const Scenario& scenario,
                                       const std::vector<Eigen::Matrix3d>& R_world_arm);

/// The sensor of a member, with its seed and faults in the scenario.
ForceSensorOptions sensor_options(const Scenario& scenario, int member);
/// One channel of a wall's sensor, from 0 to ScenarioWall::sensor_axes - 1.
ForceSensorOptions wall_sensor_options(const Scenario& scenario, int wall, int channel);

/// Values [N] that the channels of a wall's sensor measure for a force on the tip [N], in the world; unused
/// ones are zero.
Eigen::Vector3d wall_channels(const ScenarioWall& wall, const Eigen::Vector3d& force,
                              const Eigen::Matrix3d& R_world_tip) noexcept;
/// Force on the tip [N], in the world, from these values.
Eigen::Vector3d force_of_channels(const ScenarioWall& wall, const Eigen::Vector3d& channels,
                                  const Eigen::Matrix3d& R_world_tip) noexcept;

}  // namespace veridyn
