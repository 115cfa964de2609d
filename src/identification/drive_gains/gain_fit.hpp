#pragma once

#include <vector>

#include "identification/drive_gains/gain_data.hpp"

namespace veridyn {

/// The solution for one division of the recordings into loaded and unloaded ones.
struct GainFit {
  std::vector<bool> loaded;
  GainData::Columns columns;
  VectorXd sigma;  ///< (n) rms of the currents that are left
  GainSolution solution;
  VectorXd deviation;  ///< (unknowns, then joints) of x and p, jackknife over clusters; infinite
                       ///< for gains that nothing ties to the mass
  int clusters = 0;
  VectorXd mass_share;  ///< (n) of the rms torque in loaded recordings, the known mass makes

  Eigen::Index joints() const { return sigma.size(); }
  double p_deviation(Eigen::Index joint) const { return deviation[solution.y.size() + joint]; }
};

/// Solution and deviations. @param loads  as given to data.
GainFit fit_gains(const GainData& data, const std::vector<KnownMass>& loads,
                  const std::vector<bool>& loaded);

/// The division in two groups that fits best, the heavier one loaded. Which that is, is the sign of
/// the gains: exchanging the groups turns all of them.
GainFit best_division(const GainData& data, const std::vector<KnownMass>& loads);

/// Signed number of joints that feel the mass, each by how well it does: below zero where currents
/// grow when the load is taken off.
double direction(const GainFit& fit);

}  // namespace veridyn
