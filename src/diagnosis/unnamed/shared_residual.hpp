#pragma once

#include <optional>

#include "diagnosis/unnamed/motion_signals.hpp"

namespace veridyn {

/// Another joint's residual that goes together with one joint's.
struct SharedResidual {
  int with = 0;
  double correlation = 0.0;  ///< over all training rows
};

/// The residual that correlates most with this joint's, with the same sign in every fold, where it predicts more than
/// limits.unnamed_share of the joint's mean square: one cause may act on both.
std::optional<SharedResidual> shared_residual(const MotionRows& train, int joint, const Thresholds& limits);

}  // namespace veridyn
