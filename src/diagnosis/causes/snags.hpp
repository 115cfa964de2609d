#pragma once

#include <string>
#include <vector>

#include "veridyn/diagnosis/thresholds.hpp"
#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// Local friction: extra friction of one joint at one place of its travel, in one recording only,
/// as of a rail that catches or a cable that rubs. It is no property of the arm.
struct Snag {
  std::string source;  ///< the recording
  int joint = 0;       ///< from 0
  double from = 0.0;   ///< position [rad] or [m]
  double to = 0.0;
  double friction = 0.0;  ///< in excess of the other recordings [N m] or [N]
};

/// Compares friction by place between recordings; needs three of them.
std::vector<Snag> find_snags(const Identification& id, const Thresholds& limits);

/// Text for a technician.
std::string snag_text(const Snag& snag, const Coordinate& joint);

/// The intervals in which a joint is within its snag.
std::vector<ExcludedInterval> excluded_intervals(const std::vector<Snag>& snags, const Identification& id);

}  // namespace veridyn
