#pragma once

#include <optional>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// The nearest frame up the tree, itself included, that a joint moves; nullopt: none. Frames with the same
/// moving frame belong to one rigid body.
inline std::optional<FrameIndex> moving_frame(const Model& arm, std::optional<FrameIndex> frame) {
  while (frame && arm.frames()[frame->value].type == JointType::kFixed) frame = arm.frames()[frame->value].parent;
  return frame;
}

}  // namespace veridyn
