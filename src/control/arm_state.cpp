#include "veridyn/control/arm_state.hpp"

#include <cassert>

#include "control/effect_kinds.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

VectorXd values_of(const Model& arm) {
  const auto phi = arm.inertial_values();
  require(phi.has_value(), "ArmState: arm '", arm.name(),
          "' has bodies without mass, com and inertia; identify it first.");
  return *phi;
}

}  // namespace

ArmState::ArmState(const Model& arm, const Tip& tip)
    : tip_(arm, tip),
      rigid_(arm, values_of(arm)),
      rotors_(MatrixXd::Zero(arm.joints(), arm.joints())),
      q_(VectorXd::Zero(arm.joints())),
      dq_(q_),
      rest_(q_),
      h_(q_),
      bias_(q_),
      M_(rotors_) {
  for (const EffectTerm& term : arm.effects()) {
    const EffectKind kind = effect_kind(term.effect);
    if (kind == EffectKind::kFriction) continue;
    BoundEffect effect(arm, term);
    if (kind == EffectKind::kLeftOut) {
      left_out_.push_back(term.effect + "(" + axis_text(arm, term.axis) + ")");
      continue;
    }
    require(effect.has_values(), "ArmState: effect ", effect.parameter_name(0), " of arm '",
            arm.name(), "' has no value; identify it first.");
    const VectorXd& c = term.axis.coefficients;
    if (kind == EffectKind::kInertia)
      rotors_ += effect.values()[0] * c * c.transpose();
    else
      forces_.push_back(std::move(effect));
  }
}

void ArmState::update(const VectorXd& q, const VectorXd& dq) noexcept {
  assert(q.size() == joints() && dq.size() == joints());
  q_ = q;
  dq_ = dq;
  tip_.update(q_, dq_);
  rigid_.evaluate(q_, dq_, M_, h_);
  M_ += rotors_;
  bias_ = h_;
  for (BoundEffect& effect : forces_) {
    const AxisSample sample = effect.sample(0.0, q_.data(), dq_.data(), rest_.data(), 1);
    const double force = effect.force(sample);
    const VectorXd& c = effect.term().axis.coefficients;
    for (Eigen::Index i = 0; i < c.size(); ++i) bias_[i] += c[i] * force;
  }
}

}  // namespace veridyn
