#include "veridyn/control/computed_torque.hpp"

#include <cassert>

#include "veridyn/math/require.hpp"

namespace veridyn {

ComputedTorque::ComputedTorque(int joints, const JointGains& gains)
    : gains_(gains), y_(VectorXd::Zero(joints)), tau_(y_) {
  for (const VectorXd* gain : {&gains.p, &gains.d}) {
    require(gain->size() == joints && gain->allFinite() && gain->minCoeff() >= 0.0,
            "ComputedTorque: found gains that are not ", joints,
            " finite numbers, none below zero.");
  }
}

const VectorXd& ComputedTorque::update(const ArmState& arm, const JointReference& wanted) noexcept {
  assert(arm.joints() == y_.size() && wanted.q.size() == y_.size());
  y_ = wanted.ddq + gains_.p.cwiseProduct(wanted.q - arm.q()) +
       gains_.d.cwiseProduct(wanted.dq - arm.dq());
  tau_ = arm.bias();
  tau_.noalias() += arm.mass_matrix().lazyProduct(y_);
  return tau_;
}

}  // namespace veridyn
