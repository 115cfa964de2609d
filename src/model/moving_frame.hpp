#pragma once

#include <optional>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// The nearest frame up the tree that a joint moves, the frame itself included; nullopt: none does. Frames with the same one
/// belong to one rigid body.
inline std::optional<FrameIndex> moving_frame(const Model& arm, std::optional<FrameIndex> frame) {
  while (frame && arm.frames()[frame->value].type == JointType::kFixed) frame = arm.frames()[frame->value].parent;
  return frame;
}

}  // namespace veridyn
