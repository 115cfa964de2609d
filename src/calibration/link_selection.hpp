#pragma once

#include <string>
#include <vector>

#include "link_fit.hpp"

namespace veridyn::internal {

/// Which parameters the poses show.
struct LinkChoice {
  std::vector<int> independent;  ///< parameters that can be fitted together
  std::vector<std::string> why;  ///< by parameter: why it is not among them; empty: it is
  double rank_gap = 0.0;
};

/// Independent columns in the order of the parameters, by the code that finds base parameters; then,
/// if `leave_out_loose`, those that these poses, with this noise, leave uncertain by more than is
/// worth fitting are taken away one by one, worst first.
LinkChoice identifiable_links(const LinkParameters& parameters, const LinkNormal& normal,
                              bool leave_out_loose = true);

/// Deviations of the active parameters, (active), for residuals of variance one.
VectorXd deviations(const LinkNormal& normal, const std::vector<int>& active);

/// What one more parameter would gain at a minimum over the active ones.
struct LinkGain {
  double gain = 0.0;       ///< fall of the sum of squares
  double step = 0.0;       ///< by how much the parameter would change
  double deviation = 0.0;  ///< its standard deviation, for residuals of variance one; 0: no column
};
std::vector<LinkGain> gains(const LinkNormal& normal, const std::vector<int>& active);

}  // namespace veridyn::internal
