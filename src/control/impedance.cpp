#include "veridyn/control/impedance.hpp"

#include <cassert>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

bool are_valid(const ImpedanceGains& gains) {
  return gains.mass.allFinite() && gains.damping.allFinite() && gains.stiffness.allFinite() &&
         gains.mass.minCoeff() > 0.0 && gains.damping.minCoeff() >= 0.0 &&
         gains.stiffness.minCoeff() >= 0.0;
}

}  // namespace

Impedance::Impedance(const Model& arm, const Tip& tip, const ImpedanceGains& gains,
                     const ImpedanceOptions& options)
    : gains_(gains),
      options_(options),
      task_(arm.joints(), options.rows, options.home),
      inverse_(arm, tip, options.rows, options.inverse),
      y0_(VectorXd::Zero(arm.joints())),
      y_(y0_),
      tau_(y0_),
      error_(y0_),
      velocity_(y0_),
      none_(y0_) {
  require(are_valid(gains),
          "Impedance: found gains that are not finite, or a damping or stiffness below zero, or a "
          "mass that is not above it.");
  require(options.posture.size() == 0 ||
              (options.posture.size() == arm.joints() && options.posture.allFinite()),
          "Impedance: found a posture of ", options.posture.size(), " entries, expected none or ",
          arm.joints(), " finite ones.");
  require(options.posture_p >= 0.0 && options.posture_d >= 0.0,
          "Impedance: found posture gains of ", options.posture_p, " and ", options.posture_d,
          ", expected none below zero.");
}

bool Impedance::set_gains(const ImpedanceGains& gains) noexcept {
  if (!are_valid(gains)) return false;
  gains_ = gains;
  return true;
}

const VectorXd& Impedance::update(const ArmState& arm, const TaskReference& wanted,
                                  const Vector6d& wrench_world) noexcept {
  assert(arm.joints() == y_.size());
  task_.update(arm.tip());
  inverse_.update(task_.jacobian());
  const Vector6d pull =
      gains_.stiffness.cwiseProduct(task_.difference(wanted.x)) - task_.wrench(wrench_world);
  const Vector6d effort = pull + gains_.damping.cwiseProduct(wanted.dx - task_.dx());
  Vector6d a = wanted.ddx + effort.cwiseQuotient(gains_.mass);
  a.noalias() -= task_.jacobian_rate().lazyProduct(arm.dq());
  y0_ = -options_.posture_d * arm.dq();
  if (options_.posture.size() != 0) y0_ += options_.posture_p * (options_.posture - arm.q());
  inverse_.solve(a, y0_, y_);
  Vector6d lacking = Vector6d::Zero();
  for (int r = 0; r < inverse_.rows(); ++r) {
    if (gains_.stiffness[r] > 0.0) lacking[r] = pull[r] / gains_.stiffness[r];
  }
  inverse_.solve(lacking, none_, error_);
  inverse_.solve(wanted.dx, none_, velocity_);
  tau_ = arm.bias();
  tau_.noalias() += arm.mass_matrix().lazyProduct(y_);
  tau_.noalias() += arm.tip().jacobian().transpose().lazyProduct(wrench_world);
  return tau_;
}

}  // namespace veridyn
