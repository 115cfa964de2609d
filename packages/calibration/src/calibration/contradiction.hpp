#pragma once

#include <string>

#include "closed_forms.hpp"

namespace veridyn::internal {

/// Residuals of a fit over its own poses.
struct LeftOver {
  int outliers = 0;    ///< poses that it does not describe
  double rms = 0.0;    ///< [m] of positions, without those
  double angle = 0.0;  ///< [rad] likewise of orientations; 0 where they do not count
};

/// Reason why the poses contradict the relation that was fitted, or empty. They do where more than half
/// of them are outliers, or where more than half of what they vary by is left over: rows that do not
/// belong together, another frame, or a body that does something else.
std::string contradiction(const Isometries& poses, const LeftOver& left);

}  // namespace veridyn::internal
