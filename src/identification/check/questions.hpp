#pragma once

#include <functional>
#include <string>
#include <vector>

#include "identification/check/quick_fit.hpp"
#include "veridyn/model/model.hpp"
#include "veridyn/recordings/recording.hpp"

namespace veridyn {

/// One mistake that a recording or a robot file may hold, and the options that undo it.
struct RecordingQuestion {
  std::string finding;  ///< name of the finding, see check_against()
  int joint = 0;        ///< from 1; 0: all
  int second = 0;       ///< the other joint of an exchange, from 1; 0: none
  std::string what;     ///< "Positions are degrees"
  std::string units = {};  ///< of --units, which apply_to() applies; empty: none
  std::string map = {};    ///< of --map, likewise
  std::string other = {};  ///< another option, or what to write in the robot file
  std::function<void(Recording&)> rows = {};  ///< likewise, where `other` concerns the recording
  std::function<void(ModelDescription&)> robot = {};  ///< null: the robot stays
  /// Questions next to this one at a distance, as directions of gravity [rad] and gear ratios (relative) have; null: none.
  std::function<std::vector<RecordingQuestion>(double)> neighbours = {};
  double first_distance = 0.0;  ///< between questions of the list
  double price = 0.0;           ///< cost of a fitted number, in addition to that of every hypothesis
  bool is_cause = false;        ///< a diagnosis measures it as a cause

  bool changes_recording() const { return !units.empty() || !map.empty() || rows; }
  /// True if neither motion nor robot change, and torques linearly.
  bool maps_torques() const { return !robot && !rows && (units + map).find('q') == std::string::npos && units != "tau=load"; }
  /// True if everything of both joints is exchanged.
  bool is_whole() const;
  /// True if at most one of both can hold.
  bool excludes(const RecordingQuestion& other_one) const;
};

/// The list: units, signs, exchanged joints, direction of gravity, convention of DH rows.
/// @param moves  joints that move.
/// @param fit  of the recording with the transformations so far: joints that it explains are not exchanged.
std::vector<RecordingQuestion> questions_of(const Model& arm, const Recording& recording, const std::vector<bool>& moves, const QuickFit& fit);

/// True if positions of a joint (from 0) leave its limits.
bool leaves_limits(const Model& arm, int joint, const Recording& recording);

/// Gravity in this direction; a vector of zeros: the torques hold none.
RecordingQuestion gravity_along(const Eigen::Vector3d& gravity);

/// "--units q=deg --map tau1=tau2,tau2=tau1", of all questions together.
std::string options_of(const std::vector<RecordingQuestion>& questions);

/// True if some of them change the robot.
bool concern_robot(const std::vector<RecordingQuestion>& set);

/// The robot after the transformations of a set.
Model applied(const std::vector<RecordingQuestion>& set, const Model& arm);

/// Transforms a recording of this arm. Columns are exchanged before they are scaled, as the reader does.
void apply_to(const std::vector<RecordingQuestion>& set, const Model& arm, Recording& recording);

}  // namespace veridyn
