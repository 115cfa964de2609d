#pragma once

#include "veridyn/control/impedance.hpp"
#include "veridyn/cooperation/scenario.hpp"

namespace veridyn {

// What a scenario's loops are made with; one place for the loops and for their linearisation.

constexpr double kPostureStiffness = 25.0;  ///< [1/s^2] of what the task leaves free
constexpr double kPostureDamping = 10.0;    ///< [1/s]

/// Of an impedance, and of a position loop: a mass of one, accelerations whatever the arm weighs.
ImpedanceGains impedance_gains(const ScenarioControl& control);
ImpedanceGains position_gains(const ScenarioControl& control);

/// CooperativeMember::share of a member: 1/2 where both ends are position loops.
double member_share(const Scenario& scenario, const ScenarioMember& member);

}  // namespace veridyn
