#include "identification/silent_joints.hpp"

#include <algorithm>

#include "identification/identification_numbers.hpp"

namespace veridyn {

std::set<int> silent_joints(const std::vector<CompressedRecording>& recordings) {
  std::set<int> out;
  const size_t joints = recordings.empty() ? 0 : recordings.front().joints.size();
  for (size_t j = 0; j < joints; ++j) {
    const bool silent = std::all_of(recordings.begin(), recordings.end(), [j](const CompressedRecording& r) {
      return std::max(-r.joints[j].minimum, r.joints[j].maximum) < IdentificationNumbers().no_torque;
    });
    if (silent) out.insert(static_cast<int>(j));
  }
  return out;
}

std::vector<ExcludedInterval> silent_rows(const std::vector<CompressedRecording>& recordings) {
  std::vector<ExcludedInterval> out;
  for (const CompressedRecording& r : recordings) {
    for (const int j : silent_joints({r})) out.push_back({r.source, j, 0.0, r.facts.duration + r.facts.dt, "no torque"});
  }
  return out;
}

}  // namespace veridyn
