#include "identification/silent_joints.hpp"

#include <algorithm>

#include "identification/identification_numbers.hpp"
#include "veridyn/effects/effect.hpp"

namespace veridyn {

std::set<int> silent_joints(const std::vector<CompressedRecording>& recordings) {
  std::set<int> out;
  const size_t joints = recordings.empty() ? 0 : recordings.front().joints.size();
  for (size_t j = 0; j < joints; ++j) {
    const bool silent = std::all_of(recordings.begin(), recordings.end(), [j](const CompressedRecording& r) {
      return std::max(-r.joints[j].minimum, r.joints[j].maximum) < identifying::numbers.no_torque;
    });
    if (silent) out.insert(static_cast<int>(j));
  }
  return out;
}

std::vector<ExcludedInterval> silent_rows(const std::vector<CompressedRecording>& recordings) {
  std::vector<ExcludedInterval> out;
  for (const CompressedRecording& r : recordings) {
    for (const int j : silent_joints({r})) out.push_back({r.source, JointIndex{j}, 0.0, r.facts.duration + r.facts.dt, "no torque"});
  }
  return out;
}

Model without_effects_of(const std::set<int>& joints, const Model& arm) {
  ModelDescription d = arm.description();
  const auto is_theirs = [&](const EffectTerm& term) {
    if (!has_axis_effect(term.effect) || term.fixed) return false;
    for (int j = 0; j < arm.joints(); ++j) {
      if (term.axis.coefficients[j] != 0.0 && joints.count(j) == 0) return false;
    }
    return true;
  };
  d.effects.erase(std::remove_if(d.effects.begin(), d.effects.end(), is_theirs), d.effects.end());
  return Model(std::move(d));
}

void exclude_joints(const std::set<int>& joints, std::vector<CompressedRecording>& recordings) {
  for (CompressedRecording& r : recordings) {
    for (auto& block : r.blocks) {
      for (const int j : joints) {
        SquareRootInformation& factor = block[static_cast<size_t>(j)];
        r.rows -= factor.rows();
        factor = SquareRootInformation(factor.columns());
      }
    }
  }
}

}  // namespace veridyn
