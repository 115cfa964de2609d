#pragma once

#include <string>
#include <vector>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// Rows of one joint whose columns are measured twice with independent noise: at the same phase of
/// two repeats of the motion.
struct RepeatedRows {
  MatrixXd A;                ///< (rows x k) columns as they are fitted
  MatrixXd Z;                ///< (rows x k) the same columns in the other repeat: the instruments
  VectorXd b;                ///< (rows) torque that belongs to A
  std::vector<int> cluster;  ///< (rows) phase of the period, counted over all recordings
};

/// Least squares and the instrumental-variable estimate of the same parameters,
///
///   x_ls = (A'WA)^-1 A'Wb,    x_iv = (Z'WA)^-1 Z'Wb
///
/// Noise in the columns (encoder steps, noisy velocities and accelerations) pulls x_ls to zero; it
/// is independent of Z, and x_iv stays consistent. What the model lacks repeats with the motion and
/// moves both alike. The contrast is tested parameter by parameter, by the jackknife over clusters
/// (Durbin 1954, Wu 1973, Hausman 1978; clustered).
struct InstrumentalEstimate {
  VectorXd least_squares, instrumental;
  VectorXd deviation;            ///< Deviation of their difference
  VectorXd p_value;              ///< per parameter; 1 where undetermined
  double degrees_of_freedom = 0.0;
};

/// @param joints   rows of every joint, all with the same k columns.
/// @param weights  of the joints' rows.
InstrumentalEstimate compare_with_instruments(const std::vector<RepeatedRows>& joints,
                                              const VectorXd& weights);

}  // namespace veridyn
