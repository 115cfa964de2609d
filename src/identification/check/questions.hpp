#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "identification/check/quick_fit.hpp"
#include "veridyn/model/model.hpp"
#include "veridyn/recordings/recording.hpp"
#include "veridyn/recordings/recording_quality.hpp"

namespace veridyn {

/// A mistake that a recording or a robot file may contain, and the options that correct it.
struct RecordingQuestion {
  QualityKind kind;  ///< of the finding
  std::optional<JointIndex> joint = {};   ///< nullopt: all
  std::optional<JointIndex> second = {};  ///< the other joint of an exchange
  std::string what = {};  ///< "Positions are degrees"
  std::string units = {};  ///< units for --units, applied by apply_to(); empty: none
  std::string map = {};    ///< for --map, applied by apply_to(); empty: none
  std::string other = {};  ///< other correction: an option, or an entry of the robot file
  std::function<void(Recording&)> rows = {};  ///< correction of the rows, if `other` concerns the recording
  std::function<void(ModelDescription&)> robot = {};  ///< correction of the robot; null: none
  /// Hypotheses at a distance from this one: directions of gravity [rad], relative gear ratios; where rows are
  /// excluded, the same for the rows on the other side [s], if they are a third of all; null: none.
  std::function<std::vector<RecordingQuestion>(double)> neighbours = {};
  double first_distance = 0.0;  ///< distance between the hypotheses of the list
  double price = 0.0;           ///< cost of a fitted number, in addition to that of every hypothesis
  bool is_cause = false;        ///< a diagnosis estimates it as a cause

  bool changes_recording() const { return !units.empty() || !map.empty() || rows; }
  /// True if the correction is a linear map of the torques, and leaves motion and robot unchanged.
  bool maps_torques() const { return !robot && !rows && (units + map).find('q') == std::string::npos && units != "tau=load"; }
  /// True if all signals of two joints are exchanged.
  bool is_whole() const;
  /// True if at most one of the two can be correct.
  bool excludes(const RecordingQuestion& other_one) const;
};

/// The hypotheses: units, signs, exchanged joints, direction of gravity, convention of DH rows.
/// @param given  options with which the recording was read: each unit may be wrong.
/// @param moves  joints that move.
/// @param fit  fit of the recording with the transformations found so far: joints that it explains are not
/// exchanged.
std::vector<RecordingQuestion> questions_of(const Model& arm, const Recording& recording, const SignalChoice& given, const std::vector<bool>& moves, const QuickFit& fit);

/// True if positions of a joint lie outside of its limits.
bool leaves_limits(const Model& arm, JointIndex joint, const Recording& recording);

/// Gravity in this direction; zero: the torques contain no gravity.
RecordingQuestion gravity_along(const Eigen::Vector3d& gravity);

/// Options that correct all of these mistakes in a recording that was read with the given options, and replace them:
/// "--units q=deg --map tau1=tau2,tau2=tau1".
std::string options_of(const std::vector<RecordingQuestion>& questions, const SignalChoice& given, const Model& arm);

/// The given units and maps as options: "--units q=deg"; empty: none.
std::string given_options(const SignalChoice& given);

/// True if some of them change the robot.
bool any_changes_robot(const std::vector<RecordingQuestion>& set);

/// The robot after the corrections of a set.
Model corrected_arm(const std::vector<RecordingQuestion>& set, const Model& arm);

/// Applies the corrections to a recording of this arm. Columns are exchanged before they are scaled, as in
/// the reader.
void apply_to(const std::vector<RecordingQuestion>& set, const Model& arm, Recording& recording);

}  // namespace veridyn
