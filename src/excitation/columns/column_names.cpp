#include "excitation/columns/column_names.hpp"

#include "veridyn/effects/effect.hpp"
#include "model/inertial_names.hpp"

namespace veridyn {

std::vector<ColumnName> column_names(const Model& arm) {
  std::vector<ColumnName> out;
  for (const auto frame : arm.bodies()) {
    for (int c = 0; c < kBodyParameters; ++c) {
      out.push_back(
          {std::string(inertial_symbol(c)) + "_" + arm.frames()[frame].name, inertial_unit(c)});
    }
  }
  for (const EffectTerm& term : arm.effects()) {
    const BoundEffect effect(arm, term);
    for (int p = 0; p < effect.parameter_count(); ++p)
      out.push_back({effect.parameter_name(p), effect.unit(p)});
  }
  return out;
}

}  // namespace veridyn
