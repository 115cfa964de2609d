#include "effect_sizes.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "regressor/effect_along.hpp"
#include "plant_torques.hpp"
#include "kinematics/standard_motion.hpp"

namespace veridyn {
namespace {

constexpr int kSubsteps = 4;

double rms(const VectorXd& x) {
  return std::sqrt(x.squaredNorm() / static_cast<double>(std::max<Eigen::Index>(1, x.size())));
}

std::vector<std::string> missing_parameters(const EffectTerm& term) {
  std::vector<std::string> missing;
  for (const EffectParameter& p : find_effect(term.effect).parameters()) {
    if (term.values.count(p.name) == 0) missing.push_back(p.name);
  }
  return missing;
}

}  // namespace

Model with_sensible_effects(const Model& arm, double least_effort) {
  const MotionSamples motion = standard_motion(arm);
  const MatrixXd rigid = rigid_torques(arm, motion);
  const MatrixXd tau = plant_torques(arm, motion, kSubsteps);
  ModelDescription out = arm.description();
  for (EffectTerm& term : out.effects) {
    const std::vector<std::string> missing = missing_parameters(term);
    if (missing.empty()) continue;
    const std::vector<EffectParameter> parameters = find_effect(term.effect).parameters();
    const double effort = std::max(least_effort, rms(effort_along(term.axis, tau)));
    const double part = kSensibleShare * effort / static_cast<double>(missing.size());
    const MatrixXd columns = term_columns(arm, term, motion, rigid, kSubsteps);
    for (size_t p = 0; p < parameters.size(); ++p) {
      if (std::find(missing.begin(), missing.end(), parameters[p].name) == missing.end()) continue;
      const double size = rms(columns.col(p));
      // An effect that this motion does not excite (some shapes need more) gets no force.
      term.values[parameters[p].name] = size > 0.0 ? part / size : 0.0;
    }
  }
  return Model(std::move(out));
}

VectorXd standard_effort(const Model& arm) {
  const MatrixXd tau = plant_torques(arm, standard_motion(arm), kSubsteps);
  return (tau.colwise().squaredNorm() / static_cast<double>(tau.rows())).cwiseSqrt().transpose();
}

}  // namespace veridyn
