#pragma once

#include <string>
#include <vector>

#include "veridyn/cooperation/scenario.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// The true arm of a scenario and the model of its controller.
struct ScenarioModels {
  Model real, known;
  Eigen::Matrix3d R_world_base;        ///< the true base
  Eigen::Vector3d p_world_base;        ///< [m] position of the true base
  Eigen::Matrix3d R_world_base_known;  ///< the base as calibrated
  Eigen::Vector3d p_world_base_known;  ///< [m] position of the base as calibrated
};

/// R_world_base of Rz(c) Ry(b) Rx(a).
Eigen::Matrix3d base_rotation(const Eigen::Vector3d& turn);

/// A sentence for every file of an arm or its controller without values: how many values scenario_models()
/// chooses, and with which seed. @throws InvalidInput  a file that cannot be read.
std::vector<std::string> assumed_values(const Scenario& scenario);

/// Models of arm `index` of the scenario. The true arm has the gravity of its turned base.
/// @throws InvalidInput  the arm's model or start is invalid.
ScenarioModels scenario_models(const Scenario& scenario, std::size_t index);

}  // namespace veridyn
