#pragma once

#include <vector>

#include "hide_and_seek/bench.hpp"

namespace veridyn::seek {

/// The part of the torque of hidden causes that the robot file's own parameters cannot absorb, without noise.
struct Visibility {
  double share = 0.0;           ///< of the causes' torque (rms over noise, all joints) that is left
  std::vector<double> residue;  ///< per joint: rms of what is left, share of the joint's rms torque
  /// Sum over joints of ln(1 + residue^2 / noise^2) in the band below 5 Hz: upper bound of the
  /// `gain` of a finding.
  double best_gain = 0.0;
  /// Signal-to-noise ratio of a matched filter that knows the exact shape of the remaining torque:
  /// sqrt(sum residue^2 / noise^2) over independent samples.
  double oracle_t = 0.0;
  /// The probability of this oracle_t by chance is below 1 / 16,000. Smaller causes are not
  /// detectable and are no cases.
  bool beyond_doubt = false;

  /// True for a case: beyond doubt, and the robot's own parameters absorb less than nine tenths of it.
  bool observable() const { return beyond_doubt && share >= 0.1; }
};

/// @param ideal   recordings with the causes.
/// @param absorb  true: the robot's bodies, friction and offsets are fitted anew (a bare robot);
///                false: they are known (a MODEL of the same arm without the causes).
Visibility visibility(const Bench& bench, const std::vector<IdealRecording>& ideal, bool absorb);

}  // namespace veridyn::seek
