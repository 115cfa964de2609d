#include "veridyn/control/arm_state.hpp"

#include <cassert>

#include "control/static_forces.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {

ArmState::ArmState(const Model& arm) : ArmState(arm, {default_tip(arm)}) {}

ArmState::ArmState(const Model& arm, const Tip& tip)
    : tip_(arm, tip),
      rigid_(arm, control_parameters(arm, "ArmState")),
      rotors_(MatrixXd::Zero(arm.joints(), arm.joints())),
      forces_(static_forces(arm)),
      q_(VectorXd::Zero(arm.joints())),
      dq_(q_),
      rest_(q_),
      h_(q_),
      bias_(q_),
      M_(rotors_) {
  for (const EffectTerm& term : arm.effects()) {
    const BoundEffect rotor(arm, term);
    const ControlPart part = control_part(rotor.traits());
    if (part == ControlPart::kLeftOut)
      left_out_.push_back(term.effect + "(" + axis_text(arm, term.axis) + ")");
    if (part != ControlPart::kInertia) continue;
    require(rotor.has_values(), "ArmState: effect ", rotor.parameter_name(0), " of arm '",
            arm.name(), "' has no value; identify it first.");
    const VectorXd& c = term.axis.coefficients;
    rotors_ += rotor.inertia() * c * c.transpose();
  }
  for (const EffectTerm& term : arm.arm_effects()) left_out_.push_back(term.effect + "(arm)");
}

void ArmState::update(const VectorRef& q, const VectorRef& dq) noexcept {
  assert(q.size() == joints() && dq.size() == joints());
  q_ = q;
  dq_ = dq;
  tip_.update(q_, dq_);
  rigid_.equation_of_motion(q_, dq_, M_, h_);
  M_ += rotors_;
  bias_ = h_;
  add_forces(forces_, q_, dq_, rest_, bias_);
}

}  // namespace veridyn
