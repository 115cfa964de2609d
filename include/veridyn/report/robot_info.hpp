#pragma once

#include <optional>
#include <string>
#include <vector>

#include "veridyn/identification/base_parameters.hpp"
#include "veridyn/regressor/standard_parameters.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// Contents of a robot file, and the identifiability of its parameters.
struct RobotInfo {
  Model arm;
  std::vector<StandardParameter> parameters;
  BaseParameters base;
  std::optional<VectorXd> base_values;  ///< K phi; nullopt where the file lacks part of phi

  /// Coordinates, frames, effects, base parameters and the class of every standard parameter, as
  /// aligned text of at most 100 columns.
  std::string report() const;
};

/// @throws InvalidInput  the arm has an effect that does not act along an axis.
RobotInfo robot_info(const Model& arm);

/// Names of the standard parameters of one class.
std::vector<std::string> parameters_of_class(const RobotInfo& info, Identifiability class_wanted);

}  // namespace veridyn
