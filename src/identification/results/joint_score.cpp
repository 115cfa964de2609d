#include "veridyn/identification/joint_score.hpp"

#include <fmt/format.h>

#include <cmath>
#include <ostream>

#include "veridyn/math/require.hpp"

namespace veridyn {

std::ostream& operator<<(std::ostream& out, const JointScore& score) {
  out << fmt::format("joint {} ({}): error {:.3g} % of its torque", score.joint.value + 1, score.name,
                     100.0 * score.error);
  return std::isfinite(score.floor) ? out << fmt::format(", {:.3g} % between repeats", 100.0 * score.floor) : out;
}

std::vector<JointScore> validate(const Model& arm, const Recordings& recordings,
                                 const IdentificationOptions& options) {
  const Identification seen = evaluate(arm, recordings, {}, options);
  require(seen.status == IdentificationStatus::kDone, "validate: ", seen.reason, ".");
  std::vector<JointScore> out;
  for (int i = 0; i < arm.joints(); ++i) {
    out.push_back({{i}, arm.coordinates()[i].name, seen.train_error.relative[i], seen.train_error.maximum[i],
                   seen.train_error.moving_relative[i],
                   seen.noise_floor.size() > i ? seen.noise_floor[i] : std::nan("")});
  }
  return out;
}

std::vector<JointScore> validate(const Identification& fit, const Recordings& recordings) {
  require(fit.model.has_value(), "validate: there is no model: ", fit.reason, ".");
  IdentificationOptions how;
  how.preprocessing = fit.test_preprocessing;
  return validate(*fit.model, recordings, how);
}

}  // namespace veridyn
