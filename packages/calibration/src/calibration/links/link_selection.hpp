#pragma once

#include <string>
#include <vector>

#include "calibration/links/link_fit.hpp"
#include "calibration/links/links_numbers.hpp"

namespace veridyn::internal {

/// Identifiable parameters of a set of poses.
struct LinkChoice {
  std::vector<int> independent;  ///< parameters that can be fitted together
  std::vector<std::string> why;  ///< reason for which a parameter is excluded; empty: included
  double rank_gap = 0.0;
};

/// Independent columns in the order of the parameters, determined as for base parameters. If
/// `leave_out_loose`, parameters with too large an uncertainty are then removed one by one, worst first, and
/// replaced by dependent ones that are well determined without them.
LinkChoice identifiable_links(const LinkParameters& parameters, const LinkNormal& normal, bool leave_out_loose = true);

/// (active) Standard deviations of the active parameters, for residuals of variance one.
VectorXd standard_deviations(const LinkNormal& normal, const std::vector<int>& active);

/// Effect of adding one parameter at a minimum over the active ones.
struct LinkGain {
  double gain = 0.0;       ///< decrease of the sum of squares
  double step = 0.0;       ///< change of the parameter
  double deviation = 0.0;  ///< its standard deviation, for residuals of variance one; 0: no column
};
/// One per parameter.
std::vector<LinkGain> gains_of_adding(const LinkNormal& normal, const std::vector<int>& active);

}  // namespace veridyn::internal
