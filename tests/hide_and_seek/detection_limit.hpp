#pragma once

#include <string>
#include <vector>

#include "hide_and_seek/board.hpp"

namespace veridyn::seek {

/// One case: how large the hidden effect was, and whether it was named with its joint.
struct SizedCase {
  double share = 0.0;  ///< rms torque of the effect per rms torque of its joint
  bool named = false;
};

/// Sizes at which half and nine tenths of the cases are named.
struct DetectionLimit {
  double half = 0.0;
  double nine_tenths = 0.0;
  int cases = 0;
};

/// Maximum likelihood of a logistic curve over the logarithm of the size,
///
///   P(named) = 1 / (1 + (half / share)^steepness),   0.5 <= steepness <= 8
///
/// NaN if no case or every case was named: the limit lies outside of the sizes that were tried.
DetectionLimit detection_limit(const std::vector<SizedCase>& cases);

/// Plays every effect of a board on every arm at these sizes and prints the limits, in percent of
/// the joint's rms torque.
void print_detection_limits(const BoardRequest& request, const std::vector<double>& sizes);

}  // namespace veridyn::seek
