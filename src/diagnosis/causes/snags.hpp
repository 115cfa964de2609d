#pragma once

#include <string>
#include <vector>

#include "veridyn/diagnosis/thresholds.hpp"
#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// Extra friction of one joint at one place of its way, in one recording only: a rail that catches,
/// a cable that rubs. It says nothing about the arm of the other recordings.
struct Snag {
  std::string source;  ///< the recording
  int joint = 0;       ///< from 0
  double from = 0.0;   ///< position [rad] or [m]
  double to = 0.0;
  double friction = 0.0;  ///< in excess of the other recordings [N m] or [N]
};

/// Compares friction by place between recordings; needs three of them.
std::vector<Snag> find_snags(const Identification& id, const Thresholds& limits = {});

/// For a technician.
std::string snag_text(const Snag& snag, const Coordinate& joint);

/// The moments at which a joint is in its snag.
std::vector<LeftOut> left_out_rows(const std::vector<Snag>& snags, const Identification& id);

}  // namespace veridyn
