#pragma once

#include "veridyn/effects/channel_effect.hpp"

namespace veridyn {

/// A lasting error of the recorded torque of one joint, or the same error on all joints.
class TorqueChannel : public SensorError {
 public:
  EffectTraits traits(const ShapeValues& /*shape*/) const final {
    EffectTraits t;
    t.role = EffectRole::kSensor;
    t.lasting = true;
    return t;
  }
  bool can_be_common() const final { return true; }
  bool acts_on(int i, std::optional<JointIndex> joint) const final { return !joint || i == joint->value; }
};

}  // namespace veridyn
