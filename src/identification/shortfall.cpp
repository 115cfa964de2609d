#include "shortfall.hpp"

#include <algorithm>

#include "identification/identification_numbers.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
std::vector<std::string> still_joints(const Model& arm,
                                      const std::vector<CompressedRecording>& recordings) {
  std::vector<std::string> still;
  for (size_t i = 0; i < arm.coordinates().size(); ++i) {
    const Coordinate& coordinate = arm.coordinates()[i];
    double travel = 0.0;
    for (const CompressedRecording& r : recordings) travel = std::max(travel, r.joints[i].travel());
    if (travel < (coordinate.prismatic ? identifying::numbers.still_prismatic : identifying::numbers.still_revolute))
      still.push_back(coordinate.name);
  }
  return still;
}

std::string shortfall(const BaseParameters& arm_base, const BaseParameters& data_base,
                      const std::vector<std::string>& still) {
  if (!still.empty()) {
    std::string names;
    for (const std::string& name : still) names += (names.empty() ? "" : ", ") + name;
    return (still.size() > 1 ? "joints " + names + " never move" : "joint " + names + " never moves") + " (--fix " + still.front() + "=VALUE holds a joint there)";
  }
  if (data_base.size() >= arm_base.size()) return "";
  return text("the recordings determine ", data_base.size(), " of ", arm_base.size(),
              " base parameters");
}

}  // namespace veridyn
