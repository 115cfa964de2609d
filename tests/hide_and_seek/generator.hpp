#pragma once

#include <string>
#include <vector>

#include "hide_and_seek/bench.hpp"
#include "hide_and_seek/visibility.hpp"

namespace veridyn::seek {

/// What a diagnosis starts from.
enum class Mode {
  kBare,  ///< the robot file has no values: `diagnose ROBOT`, trained on recordings with the causes
  kChanged  ///< a MODEL of the clean arm, then recordings with the causes: what changed since?
};

struct CaseRequest {
  std::string arm;
  std::vector<std::string> effects;  ///< none, one or two names of CONTRACT.md
  unsigned seed = 1;
  double share = 0.1;  ///< rms torque of an additive cause per rms torque of its joint; causes
                       ///< without such a size are scaled by share / 0.1 from plausible ones
  Mode mode = Mode::kBare;
  Trouble trouble = Trouble::kNone;  ///< of all recordings
  double noise = 0.0;  ///< of the torques, share of the joint's rms; 0: drawn, 0.03 to 0.05
  bool one_joint = false;  ///< the second of two effects is on the joint of the first
};

/// A case before its recordings are written: hidden causes and their visibility.
struct HiddenCase {
  CaseRequest request;
  Bench bench;
  std::vector<Cause> causes;
  /// Further true causes that were not requested: viscosity that falls from one recording to the
  /// next has changed since the model was identified.
  std::vector<Cause> also_true;
  std::vector<double> shares;  ///< true rms share of each cause at its joint
  Visibility visible;
  bool observable = true;  ///< false: the arm's own parameters absorb it on every joint
};

/// Names beside those of the contract:
///
///   common_delay  a time_delay of the whole arm, 10 to 45 ms
///   large_zero    an encoder_offset of 0.2 to 0.4 rad
///   large_delay   a time_delay of one joint, 20 to 50 ms
///   common_gain   a torque_gain of the whole arm
///   no_friction   the robot file has no friction at all; some joints have viscous and Coulomb
///                 friction
const std::vector<std::string>& special_cases();

/// Draws causes of the requested size on random joints (pairs on different ones). A joint is skipped
/// if the robot's own parameters absorb more than nine tenths of the cause, or if the remaining
/// torque is below the sensors' noise, see Visibility::beyond_doubt.
HiddenCase hide(const CaseRequest& request);

/// Paths of the written recordings.
struct CaseFiles {
  std::vector<std::string> clean;  ///< of the arm without the causes, kChanged only
  std::vector<std::string> train, test;
};

constexpr int kBareTrain = 4;  ///< recordings with the causes to learn from, one more is the test
constexpr int kChangedTrain = 3;  ///< in kChanged

/// Writes all recordings of a case into a folder that exists.
/// @param reach  of the motions with the causes, see Motion.
CaseFiles write_case(const HiddenCase& hidden, const std::string& folder, double reach = 1.0);

/// "torque_ripple on elbow: cosine 0.3, ..." for people.
std::string describe(const Cause& cause, const Model& robot);

}  // namespace veridyn::seek
