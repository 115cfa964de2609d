#pragma once

#include "veridyn/cooperation/scenario.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// An arm of a scenario as it is, and as its controller knows it.
struct ScenarioModels {
  Model real, known;
  Eigen::Matrix3d R_world_base;        ///< the true base
  Eigen::Vector3d p_world_base;        ///< [m]
  Eigen::Matrix3d R_world_base_known;  ///< as calibration has it
  Eigen::Vector3d p_world_base_known;  ///< [m]
};

/// R_world_base of Rz(c) Ry(b) Rx(a).
Eigen::Matrix3d base_rotation(const Eigen::Vector3d& turn);

/// Arm `index` of the scenario. The true arm feels gravity as its turned base does.
/// @throws InvalidInput  the arm's model or start cannot be.
ScenarioModels scenario_models(const Scenario& scenario, std::size_t index);

}  // namespace veridyn
