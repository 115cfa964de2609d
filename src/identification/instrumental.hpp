#pragma once

#include <string>
#include <vector>

#include "identification/base_solution.hpp"
#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// Estimates that use the noise-free motion of the model together with the measured one.
struct InstrumentalFit {
  BaseSolution solution;
  double objective = 0.0;              ///< weighted sum of squares along the measured motion
  std::vector<EndogeneityTest> tests;  ///< one for every joint
};

/// kIv: beta = (Z'WY)^-1 Z'W tau, where Y holds the base columns along the measured motion and Z
/// the same along the motion without noise (Janot, Vandanjon and Gautier, IEEE Trans. Control
/// Systems Technology 22(1), 2014). kDidim: beta = (Z'WZ)^-1 Z'W tau, which needs no measured
/// velocity or acceleration (Gautier, Janot and Vandanjon, IEEE Trans. CST 21(2), 2013).
///
/// The noise-free motion is that of the simulated arm. Under computed torque with its own values, whatever
/// they are, a simulated arm follows its reference exactly, so that the simulation equals the reference: at
/// every instant the mean of the low-passed positions at the same phase of all *other* periods, whose noise
/// is independent, with its derivatives; if nothing repeats, the low-passed positions themselves.
///
/// @param weights  of the joints' rows.
/// @throws InvalidInput  the samples of a recording are not available, or the options exclude slow ones.
InstrumentalFit fit_with_instruments(const Model& arm, const std::vector<CompressedRecording>& recordings,
                                     const BaseParameters& base, const VectorRef& weights,
                                     const IdentificationOptions& options);

/// Least squares and the instrumental-variable estimate of the same base parameters, with the measured columns of the other
/// repeats of a motion as instruments:
///
///   x_ls = (A'WA)^-1 A'Wb,    x_iv = (Z'WA)^-1 Z'Wb
///
/// Noise in the columns (encoder steps, noisy velocities and accelerations) biases x_ls towards zero; it is
/// independent of Z, so that x_iv is consistent. Errors of the model repeat with the motion and affect both
/// estimates alike. Each parameter's difference is tested by the jackknife over clusters (Durbin 1954, Wu
/// 1973, Hausman 1978; clustered).
struct InstrumentalContrast {
  VectorXd least_squares, instrumental;  ///< (base)
  VectorXd p_value;                      ///< (base) 1 where undetermined
};

/// @param recordings  only those with a repeated motion are read; without any, all p-values are one.
/// @param weights  of the joints' rows; zero for excluded joints.
InstrumentalContrast contrast_with_repeats(const Model& arm, const std::vector<CompressedRecording>& recordings,
                                           const BaseParameters& base, const VectorRef& weights,
                                           const PreprocessingOptions& how);

}  // namespace veridyn
