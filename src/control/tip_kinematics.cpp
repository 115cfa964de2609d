#include "veridyn/control/tip_kinematics.hpp"

#include <cassert>
#include <vector>

#include "math/eigen_pose.hpp"
#include "model/suggestion.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

// The tip's frame; throws InvalidInput without such a frame or with an offset that is not finite.
FrameIndex tip_frame(const Model& arm, const Tip& tip) {
  std::vector<std::string> names;
  for (const Frame& frame : arm.frames()) names.push_back(frame.name);
  const std::optional<FrameIndex> frame = arm.find_frame(tip.frame);
  require(frame.has_value(), "tip of arm '", arm.name(), "': found the frame '", tip.frame, "'",
          did_you_mean(tip.frame, names), ", expected one of: ", listed(names), ".");
  require(tip.offset_frame.allFinite(), "tip of arm '", arm.name(),
          "': found an offset that is not finite, expected three numbers in metres.");
  return *frame;
}

}  // namespace

std::string default_tip(const Model& arm) {
  std::vector<int> joints;  // joints that move each frame, its own included
  int best = -1;
  for (const Frame& frame : arm.frames()) {
    const int above = frame.parent ? joints[frame.parent->value] : 0;
    joints.push_back(above + (frame.type == JointType::kFixed ? 0 : 1));
    if (best < 0 || joints.back() >= joints[best])
      best = static_cast<int>(joints.size()) - 1;
  }
  return best < 0 ? "" : arm.frames()[best].name;
}

TipKinematics::TipKinematics(const Model& arm, const Tip& tip)
    : motion_(Tree(arm, Tree::Keep::kMovingLinks), tip_frame(arm, tip),
              {tip.offset_frame.x(), tip.offset_frame.y(), tip.offset_frame.z()}) {}

void TipKinematics::update(const VectorRef& q, const VectorRef& dq) noexcept {
  assert(q.size() == joints() && dq.size() == joints());
  motion_.update(q.data(), dq.data());
  const Posed& T = motion_.pose();
  rotation_ = eigen(T.R);
  position_ = eigen(T.p);
  const Vec3d& v = motion_.velocity();
  const Vec3d& omega = motion_.omega();
  twist_ << v.x, v.y, v.z, omega.x, omega.y, omega.z;
}

}  // namespace veridyn
