#pragma once

#include <functional>
#include <string>
#include <vector>

#include "veridyn/model/model.hpp"
#include "veridyn/recordings/recording.hpp"

namespace veridyn {

/// One hypothesis about signals that were recorded under a wrong name, in a wrong unit or with a wrong sign.
struct SignalHypothesis {
  std::string finding;
  int joint = 0;                         ///< from 1; 0: all
  std::string what;                      ///< what is wrong, a clause; empty for signs
  std::string option;                    ///< of the command line, which mends it
  std::function<void(Recording*)> mend;  ///< changes the recording
  int second = 0;                        ///< from 1; 0: none
  bool whole = false;                    ///< of both joints everything is exchanged

  /// True if at most one of both can hold. That torques of two joints are exchanged and that their motions are is one
  /// mistake, seen from either side.
  bool excludes(const SignalHypothesis& other) const;
};

/// Positions, or positions and velocities, are degrees; nothing for arms that only slide.
std::vector<SignalHypothesis> angles_in_degrees(const Model& arm, const Recording& recording);

/// The torque of a joint (from 0) has the wrong sign.
SignalHypothesis turned_torque(int joint);

/// The torques of two joints (from 0) are exchanged, their motions, or both.
/// @param pair    their names, for sentences. @param torque  name of the torques' columns, "tau" or "i".
/// @param dq      velocities are recorded, too.
std::vector<SignalHypothesis> exchanges(int i, int j, const std::string& pair, bool dq, const std::string& torque);

/// Torques are motor currents. @param gains  (joints) [N m/A]
SignalHypothesis currents(const VectorXd& gains);

}  // namespace veridyn
