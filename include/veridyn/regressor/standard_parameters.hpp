// regressor/: the torques of bodies and effects as a linear map of the standard parameters, over all samples of a motion.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "veridyn/effects/effect.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// One standard parameter: a number in which the torques are linear.
struct StandardParameter {
  std::string name;  ///< "m_tool", "hx_tool", "Lxx_tool" or "viscous_friction(yaw).coefficient"
  std::string unit;
  std::optional<int> body = {};    ///< index among the bodies
  int component = 0;   ///< index among InertialParameters, or among the effect's parameters
  std::optional<int> effect = {};  ///< index among the model's effects
  bool fixed = false;  ///< true: the robot file declares it as known
  double value = 0.0;  ///< value of the file, if it has one
  double lower = 0.0;  ///< bounds; infinite where there are none
  double upper = 0.0;
};

/// All standard parameters of an arm: bodies first (ten each, in the order of InertialParameters),
/// then effects in the order of the file. Throws for an effect that does not act along an axis.
std::vector<StandardParameter> standard_parameters(const Model& arm);

/// Values of the standard parameters; zero for an effect without values.
/// @throws InvalidInput  a body has no values.
VectorXd standard_values(const Model& arm);

/// Names of the parameters.
std::vector<std::string> parameter_names(const std::vector<StandardParameter>& parameters);

/// The arm with these values and standard deviations (NaN: none; empty: none at all) instead of its own.
/// @throws InvalidInput  another number of them than standard_parameters().
Model with_values(const Model& arm, const VectorRef& values, const VectorRef& deviations);

/// The regressor of bodies and memoryless effects at one state, (n x parameters); effects with
/// memory start from rest.
MatrixXd full_regressor(const Model& arm, const VectorRef& q, const VectorRef& dq,
                        const VectorRef& ddq);

}  // namespace veridyn
