#pragma once

#include "veridyn/effects/channel_effect.hpp"

namespace veridyn {

/// An error of the recorded torque of one joint, or of all of them alike, that lasts: what its
/// parameters change in the coordinates' `recorded` is all that distinguishes one from another.
class TorqueChannel : public ChannelEffect {
 public:
  EffectTraits traits(const ShapeValues& /*shape*/) const final {
    EffectTraits t;
    t.role = EffectRole::kChannel;
    t.stage = DiagnosisStage::kChannel;
    t.lasting = true;
    return t;
  }
  bool can_be_common() const final { return true; }
  bool acts_on(int i, int joint) const final { return joint == kAllJoints || i == joint; }

  void apply(ModelDescription& arm, int joint, const std::vector<double>& values) const final {
    for (size_t i = 0; i < arm.coordinates.size(); ++i) {
      if (acts_on(static_cast<int>(i), joint)) change(arm.coordinates[i].recorded, values[0]);
    }
  }

 private:
  virtual void change(RecordedChannel& recorded, double value) const = 0;
};

}  // namespace veridyn
