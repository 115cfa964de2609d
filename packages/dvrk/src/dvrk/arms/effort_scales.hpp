#pragma once

#include <string>
#include <vector>

#include "dvrk/arms/arm_facts.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn::dvrk {

/// Current per effort of one actuator, as configured and according to a model.
struct EffortScale {
  std::string actuator;
  std::string unit;        ///< "A/N m" or "A/N"
  double before = 0.0;     ///< Value in the configuration
  double scale = 0.0;      ///< corrected
  double std_scale = 0.0;  ///< standard deviation; 0: not known
  std::string source;      ///< origin of the correction; empty: no correction
};

/// Scales from a model's drive gains, for every actuator whose name is a coordinate of the model:
///
///   scale = recorded.torque_gain / drive_gain     (1 / before where no drive gain is identified)
///
/// A recorded torque gain of 1.1 means that reported efforts are 10 % too high, so that an ampere
/// gives less than the configuration says.
/// @throws InvalidInput  the configuration has another number of actuators than the arm.
std::vector<EffortScale> corrected_scales(const Model& model, const ArmFacts& arm,
                                          const RobotConfig& robot);

/// {"robots": [{"name", "actuators": [{"drive": {"effort_to_current": {"scale"}}, ...}]}]}: the members of a
/// JSON configuration, and next to them their origin.
std::string to_scales_json(const std::string& arm, const std::vector<EffortScale>& scales);

}  // namespace veridyn::dvrk
