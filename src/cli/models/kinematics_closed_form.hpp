#pragma once

#include <string>

#include "control/kinematics_table.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn::cli {

/// An arm with its closed-form kinematics, if it has one.
struct Arm {
  Model model;
  std::string frame;
  InverseSolver closed_form;
};

/// A robot file or name, or an arm of the dVRK ("PSM1", "MTMR", "ECM").
/// @throws InvalidInput  none of these. @throws CLI::ValidationError  no such frame.
Arm read_kinematic_arm(const std::string& robot, const std::string& frame);

}  // namespace veridyn::cli
