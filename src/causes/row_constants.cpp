#include "causes/row_constants.hpp"

#include <cmath>

#include "effects/kinematic_error.hpp"

namespace veridyn {
namespace {

bool is_ratio(const std::string& name) {
  return name.find(' ') != std::string::npos;
}

// Frames that carry a body, or a frame that does.
std::vector<bool> carriers(const Model& arm) {
  std::vector<bool> out(arm.frames().size(), false);
  for (size_t k = out.size(); k-- > 0;) {
    const Frame& frame = arm.frames()[k];
    if (frame.body) out[k] = true;
    if (out[k] && frame.parent >= 0) out[frame.parent] = true;
  }
  return out;
}

}  // namespace

std::vector<KinematicError> row_constants(const Model& arm) {
  std::vector<KinematicError> out;
  const std::vector<bool> carries = carriers(arm);
  for (int k = 0; k < static_cast<int>(arm.frames().size()); ++k) {
    const Frame& frame = arm.frames()[k];
    if (!frame.dh || !carries[k]) continue;
    for (const char* name : {"theta", "alpha", "a", "d"}) out.push_back({name, FrameIndex{k}});
    for (int i = 0; i < arm.joints(); ++i) {
      const double c = frame.variable.coefficients[i];
      if (c == 0.0 || std::abs(c) == 1.0) continue;
      out.push_back({"ratio of " + arm.coordinates()[i].name, FrameIndex{k}});
    }
  }
  return out;
}

double value_in(const Model& arm, const KinematicError& constant) {
  return value_of(constant, arm.description());
}

Model with_constant(const Model& arm, const KinematicError& constant, double value) {
  ModelDescription d = arm.description();
  set_value(constant, value, d);
  return Model(std::move(d));
}

std::string unit_of(const KinematicError& constant) {
  if (is_ratio(constant.constant)) return "1";
  return constant.constant == "theta" || constant.constant == "alpha" ? "rad" : "m";
}

std::string words_for(const Model& arm, const KinematicError& constant) {
  const auto frame = static_cast<size_t>(std::get<FrameIndex>(constant.of).value);
  return constant.constant + (is_ratio(constant.constant) ? " in frame " : " of frame ") +
         arm.frames()[frame].name;
}

}  // namespace veridyn
