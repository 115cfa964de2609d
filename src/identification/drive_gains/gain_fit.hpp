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
  /// (unknowns, then joints) standard deviations of x and p by jackknife over clusters; infinite for gains
  /// that the known mass does not determine.
  VectorXd deviation;
  int clusters = 0;
  VectorXd mass_share;  ///< (n) share of the known mass in the rms torque of loaded recordings

  Eigen::Index joints() const { return sigma.size(); }
  double p_deviation(Eigen::Index joint) const { return deviation[solution.y.size() + joint]; }
};

/// Solves, with standard deviations. @param loads  as given to `data`.
GainFit fit_gains(const GainData& data, const std::vector<KnownMass>& loads,
                  const std::vector<bool>& loaded);

/// The best division into two groups, of which the heavier one is loaded. The sign of the gains determines
/// which one that is: exchanging the groups reverses all gains.
GainFit best_division(const GainData& data, const std::vector<KnownMass>& loads);

/// Signed sum over the joints loaded by the mass, weighted by significance: negative if the currents increase
/// when the load is removed.
double direction(const GainFit& fit);

}  // namespace veridyn
