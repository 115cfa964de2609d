#include "diagnosis/search/row_constants.hpp"

#include <cmath>

#include "effects/kinematic_error.hpp"

namespace veridyn {
namespace {

// True for frames that carry a body or a frame with one.
std::vector<bool> carriers(const Model& arm) {
  std::vector<bool> out(arm.frames().size(), false);
  for (size_t k = out.size(); k-- > 0;) {
    const Frame& frame = arm.frames()[k];
    if (frame.body) out[k] = true;
    if (out[k] && frame.parent) out[frame.parent->value] = true;
  }
  return out;
}

}  // namespace

std::vector<FrameConstant> row_constants(const Model& arm) {
  std::vector<FrameConstant> out;
  const std::vector<bool> carries = carriers(arm);
  for (int k = 0; k < static_cast<int>(arm.frames().size()); ++k) {
    const Frame& frame = arm.frames()[k];
    if (!frame.dh || !carries[k]) continue;
    for (const FrameConstant& c : constants_of(arm, {k})) {
      // The coefficient of a joint that drives its own frame is no gear ratio.
      if (!c.joint || std::abs(frame.variable.coefficients[c.joint->value]) != 1.0) out.push_back(c);
    }
  }
  return out;
}

double value_in(const Model& arm, const FrameConstant& constant) {
  return value_of({constant}, arm.description());
}

Model with_constant(const Model& arm, const FrameConstant& constant, double value) {
  ModelDescription d = arm.description();
  set_value({constant}, value, d);
  return Model(std::move(d));
}

std::string words_for(const Model& arm, const FrameConstant& constant) {
  return name_of(arm, constant) + (constant.joint ? " in frame " : " of frame ") +
         arm.frames()[constant.frame.value].name;
}

}  // namespace veridyn
