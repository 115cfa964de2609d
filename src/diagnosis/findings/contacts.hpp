#pragma once

#include <string>
#include <vector>

#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn {

/// An interval in which something outside the arm pushed or held it.
struct Contact {
  std::string source;  ///< the recording
  double from = 0.0;   ///< [s] since the recording began
  double to = 0.0;
  int last_joint = 0;    ///< last joint, from 0, on which the contact has a torque: the contact is on its link
  VectorXd effort;       ///< mean torque (n) that the model does not explain [N m] or [N]
  double deviation = 0;  ///< scatter of the last joint's residual outside of the interval
  double peak = 0.0;     ///< largest residual, divided by that scatter
};

/// The rows of these contacts, for all joints.
std::vector<ExcludedInterval> excluded_intervals(const std::vector<Contact>& contacts);

/// One finding for all contacts on one link: times, torques, and the held-out error without these intervals.
/// @param seen  errors of the arm on the recordings without these intervals.
std::vector<Finding> findings_of(const std::vector<Contact>& contacts, const Identification& seen);

}  // namespace veridyn
