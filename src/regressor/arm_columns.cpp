#include "regressor/arm_columns.hpp"

#include "kinematics/motion_limits.hpp"

namespace veridyn {

std::vector<std::shared_ptr<const ColumnSource>> arm_columns(const Model& arm, double rounding) {
  std::vector<std::shared_ptr<const ColumnSource>> out{body_columns(arm)};
  const VectorXd speeds = rounding * motion_limits(arm).velocity;
  for (const EffectTerm& term : arm.effects()) out.push_back(effect_columns(arm, term, speeds));
  return out;
}

}  // namespace veridyn
