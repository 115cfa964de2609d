#pragma once

#include <string>
#include <vector>

#include "hide_and_seek/bench.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn::seek {

/// Causes that no class of the library describes. A diagnosis can report the joint, the signals and the
/// share of the error that these predict, but no name.
const std::vector<std::string>& outside_causes();

/// One of these causes with its place and all parameters.
struct OutsideCause {
  std::string name;
  int joint = -1;  ///< -1: the whole arm
  int from = -1;   ///< the other joint of a coupling
  double size = 0.0;               ///< torque per unit of its shape; a dead zone's or a limit's torque
  double place = 0.0, width = 0.0;  ///< on the signal, in its unit
  /// Signals in the words of a verdict, one of which is right; empty: any of positions and torques.
  std::vector<std::string> signals;
  std::vector<std::string> words;  ///< effects of the library with nearly the same torque
};

/// Draws a place and numbers, so that its torque has `share` of its joint's rms torque.
OutsideCause draw_outside(const Bench& bench, const std::string& name, unsigned seed, double share);

/// Adds the cause to a recording without noise.
void apply_outside(const Bench& bench, const OutsideCause& cause, IdealRecording& ideal);

/// An arm, recordings with the cause and the same without it; the last of each is held out.
struct OutsideFiles {
  Bench bench;
  OutsideCause cause;
  std::vector<std::string> with, without;
  bool observable = true;  ///< as in Visibility

  Diagnosis diagnosed(const DiagnosisOptions& options) const;
  /// Held-out error of the arm without the cause, (n) relative.
  VectorXd clean_error(const IdentificationOptions& options) const;
};

/// @param name    of the cause; "none": nothing is hidden.
/// @param share   of its joint's rms torque.
/// @param folder  of the recordings; it exists.
/// @param train   recordings to learn from.
OutsideFiles write_outside(const std::string& arm, const std::string& name, unsigned seed, double share,
                           const std::string& folder, int train);

/// Comparison of a diagnosis with one of these causes.
struct OutsideScore {
  std::string state;       ///< of its joint, or of the joint with most removable error
  bool silent = false;     ///< there is no finding on a joint that is clearly above its floor
  bool joint = false;      ///< its joint is among the findings
  bool signals = false;    ///< a curve over the right signals was found
  bool worded = false;     ///< an effect of OutsideCause::words was found
  int false_names = 0;     ///< findings with other names
  double explained = 0.0;  ///< share of the removable error, measured on the same arm without it
  bool observable = true;  ///< false: the arm's own parameters absorb it or it is below the noise; not counted
};
OutsideScore score_outside(const OutsideCause& cause, const Diagnosis& d, const VectorXd& clean);

struct OutsideRequest {
  std::vector<std::string> causes = {}, arms = bench_arms();
  std::vector<unsigned> seeds = {1};
  double share = 0.3;
  int threads = 2;
  std::string keep;
  DiagnosisOptions options;
};

/// One case: the recordings are made, identified without the cause and diagnosed with it.
OutsideScore outside_score(const OutsideRequest& request, const std::string& arm, const std::string& cause,
                           unsigned seed);

/// Plays all cases, prints a line for each and a table.
void play_outside(const OutsideRequest& request);

}  // namespace veridyn::seek
