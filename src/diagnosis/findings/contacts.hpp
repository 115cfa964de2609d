#pragma once

#include <string>
#include <vector>

#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn {

/// A moment in which something outside the arm pushed or held it.
struct Contact {
  std::string source;  ///< the recording
  double from = 0.0;   ///< [s] since the recording began
  double to = 0.0;
  int last_joint = 0;    ///< from 0: the last joint with a torque from it; the contact is on its link
  VectorXd effort;       ///< (n) mean torque that the model does not explain [N m] or [N]
  double deviation = 0;  ///< Scatter of the last joint's residual elsewhere
  double peak = 0.0;     ///< largest residual over its scatter elsewhere
};

/// The rows of these moments, for all joints.
std::vector<ExcludedInterval> excluded_intervals(const std::vector<Contact>& contacts);

/// One finding for the contacts on one link: times, efforts, and the held-out error outside of these intervals.
/// @param seen  the arm on the recordings without these intervals.
std::vector<Finding> findings_of(const std::vector<Contact>& contacts, const Identification& seen);

}  // namespace veridyn
