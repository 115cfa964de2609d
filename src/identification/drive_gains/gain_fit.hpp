#pragma once

#include <vector>

#include "identification/drive_gains/gain_data.hpp"

namespace veridyn {

/// The solution for one division of the recordings into loaded and unloaded ones.
struct GainFit {
  std::vector<bool> loaded;
  GainData::Columns columns;
  VectorXd sigma;  ///< (n) rms of the residual currents
  GainSolution solution;
  /// (unknowns, then joints) of x and p, jackknife over clusters; infinite for gains without a
  /// connection to the known mass.
  VectorXd deviation;
  int clusters = 0;
  VectorXd mass_share;  ///< (n) share of the known mass in the rms torque of loaded recordings

  Eigen::Index joints() const { return sigma.size(); }
  double p_deviation(Eigen::Index joint) const { return deviation[solution.y.size() + joint]; }
};

/// Solves, with standard deviations. @param loads  as given to data.
GainFit fit_gains(const GainData& data, const std::vector<KnownMass>& loads,
                  const std::vector<bool>& loaded);

/// The best division in two groups, the heavier one loaded. The sign of the gains decides which
/// that is: exchanging the groups reverses all of them.
GainFit best_division(const GainData& data, const std::vector<KnownMass>& loads);

/// Signed sum over the joints that the mass loads, weighted by significance: negative if currents
/// grow when the load is removed.
double direction(const GainFit& fit);

}  // namespace veridyn
