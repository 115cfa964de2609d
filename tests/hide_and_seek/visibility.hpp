#pragma once

#include <vector>

#include "hide_and_seek/bench.hpp"

namespace veridyn::seek {

/// What no choice of the robot file's own parameters can explain of hidden causes, without noise.
struct Visibility {
  double share = 0.0;           ///< of the causes' torque (rms over noise, all joints) that is left
  std::vector<double> residue;  ///< per joint: rms of what is left, share of the joint's rms torque
  /// Sum over joints of ln(1 + residue^2 / noise^2) in the band below 5 Hz: what `gain` of a
  /// finding can be at best. FINDINGS 6 accepts above 0.03; amplitudes three times as large give
  /// 0.27.
  double best_gain = 0.0;
  /// Size of the left-over torque over its standard deviation for someone who knows its course
  /// exactly and looks for nothing else: sqrt(sum residue^2 / noise^2) over independent samples.
  double oracle_t = 0.0;
  /// oracle_t is so large that chance alone brings it once in 16,000 recordings. Smaller causes
  /// cannot be named by anybody, and are no cases.
  bool beyond_doubt = false;

  /// True for a case: beyond doubt, and the robot's own parameters absorb less than nine tenths of it.
  bool observable() const { return beyond_doubt && share >= 0.1; }
};

/// @param ideal   recordings with the causes.
/// @param absorb  true: the robot's bodies, friction and offsets are fitted anew (a bare robot);
///                false: they are known (a MODEL of the same arm without the causes).
Visibility visibility(const Bench& bench, const std::vector<IdealRecording>& ideal, bool absorb);

}  // namespace veridyn::seek
