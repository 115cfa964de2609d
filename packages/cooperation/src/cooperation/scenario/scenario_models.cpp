#include "cooperation/scenario/scenario_models.hpp"

#include <Eigen/Geometry>
#include <limits>
#include <utility>

#include "cooperation/scenario/scenario_parts.hpp"
#include "veridyn/math/random_numbers.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/identification/base_parameters.hpp"
#include "veridyn/regressor/standard_parameters.hpp"
#include "veridyn/simulation/plausible_model.hpp"

namespace veridyn {
namespace {

using Eigen::AngleAxisd;
using Eigen::Vector3d;

// The model of a file with the gravity of its turned base, and plausible values if the file has none.
Model read_model_in_base(const std::string& file, const Eigen::Matrix3d& R_world_base, unsigned seed) {
  ModelDescription description = read_model(file).description();
  description.gravity = R_world_base.transpose() * description.gravity;
  return plausible_model(Model(std::move(description)), seed).arm;
}

// The controller's model of the arm: every base parameter is wrong by `share`, with a random sign. Base
// parameters are used because torques depend on nothing else; errors of hundreds of single parameters might
// cancel.
Model with_parameter_errors(const Model& arm, double share, unsigned seed) {
  if (!(share > 0.0)) return arm;
  const std::vector<StandardParameter> parameters = standard_parameters(arm);
  VectorXd phi(parameters.size());
  for (size_t k = 0; k < parameters.size(); ++k)
    phi[static_cast<Eigen::Index>(k)] = parameters[k].value;
  const BaseParameters base = base_parameters(arm);
  const VectorXd beta = base.K * phi;
  RandomNumbers random(seed, 77);
  for (int j = 0; j < base.size(); ++j) {
    const double sign = random.uniform() < 0.5 ? -1.0 : 1.0;
    phi[base.independent[j]] += sign * share * beta[j];
  }
  const VectorXd none = VectorXd::Constant(phi.size(), std::numeric_limits<double>::quiet_NaN());
  return with_values(arm, phi, none);
}

}  // namespace

Eigen::Matrix3d base_rotation(const Vector3d& turn) {
  return (AngleAxisd(turn.z(), Vector3d::UnitZ()) * AngleAxisd(turn.y(), Vector3d::UnitY()) *
          AngleAxisd(turn.x(), Vector3d::UnitX()))
      .toRotationMatrix();
}

std::vector<std::string> assumed_values(const Scenario& scenario) {
  std::vector<std::string> out;
  for (const ScenarioArm& arm : scenario.arms) {
    for (const std::string& file : {arm.model, arm.controller_model}) {
      if (file.empty()) continue;
      const PlausibleModel made = plausible_model(read_model(file), arm.seed);
      if (made.bodies + made.effects == 0) continue;
      out.push_back(text("arm ", arm.name, ": ", file, " has no values for ", made.bodies,
                         " bodies and ", made.effects, " effects: they get plausible ones (seed ",
                         arm.seed, ")."));
    }
  }
  return out;
}

ScenarioModels scenario_models(const Scenario& scenario, std::size_t index) {
  const ScenarioArm& arm = scenario.arms[index];
  const Eigen::Matrix3d R = base_rotation(arm.turn);
  const Eigen::Matrix3d R_known = base_rotation(arm.calibration_turn) * R;
  Model real = read_model_in_base(arm.model, R, arm.seed);
  check_arm(arm, real);
  const bool same = arm.controller_model.empty();
  const Model assumed_model = same ? real : read_model_in_base(arm.controller_model, R_known, arm.seed);
  require(assumed_model.joints() == real.joints(), "arm '", arm.name, "': found a controller's model of ",
          assumed_model.joints(), " joints, expected the ", real.joints(), " of the arm.");
  if (!same) check_arm(arm, assumed_model);
  return {std::move(real),
          with_parameter_errors(assumed_model, scenario.model_error,
                                scenario.seed + static_cast<unsigned>(index)),
          R,
          arm.position,
          R_known,
          arm.position + arm.calibration_position};
}

}  // namespace veridyn
