#pragma once

#include <ros/ros.h>

#include <string>
#include <vector>

#include "veridyn/model/model.hpp"

namespace veridyn_ros {

/// One arm of a node's parameters: ~arms is a list of names, ~NAME/model a robot file or MODEL, ~NAME/start
/// the initial joint positions, ~NAME/tip a frame, ~NAME/seed the seed of plausible values for a file without
/// values.
struct ArmParameters {
  std::string name;
  veridyn::Model model;
  veridyn::VectorXd start;
  std::string tip;
};

/// @throws veridyn::InvalidInput  no arms, no model, or a start of another size: one line that names the
/// parameter.
std::vector<ArmParameters> read_arms(const ros::NodeHandle& own);

/// Runs `main` of a node. @returns its exit status: 0, or 3 after an error, which is reported in one line.
int run_node(int argc, char** argv, const std::string& name, void (*run)(ros::NodeHandle& own));

}  // namespace veridyn_ros
