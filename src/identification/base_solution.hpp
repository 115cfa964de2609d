#pragma once

#include <vector>

#include "veridyn/identification/base_parameters.hpp"
#include "veridyn/identification/compressed_recording.hpp"

namespace veridyn {

/// The least-squares solution for the base parameters, computed from factors alone.
struct BaseSolution {
  VectorXd beta;       ///< (base) base parameters
  VectorXd white_std;  ///< (base) standard deviations for independent samples
  VectorXd std;        ///< (base) standard deviations by block jackknife over the blocks of all recordings
  /// F (base x clusters): the covariance of beta is F F', which gives std; (base x 0) for fewer than three
  /// clusters.
  MatrixXd scatter;
  int clusters = 0;                      ///< blocks of all recordings
  double residual2 = 0.0;                ///< weighted sum of squares
  double condition_number = 0.0;         ///< condition number of the unscaled columns
  double condition_number_scaled = 0.0;  ///< condition number of the columns scaled to norm one
  double effective_samples = 0.0;        ///< number of rows times the median of (white_std / std)^2
};

/// One factor per joint: all blocks of all recordings merged.
std::vector<SquareRootInformation> joint_totals(const std::vector<CompressedRecording>& recordings);

/// Merges the factors of the joints over the given columns, with weight weights[i] for joint i.
SquareRootInformation weighted_total(const std::vector<SquareRootInformation>& joints,
                                     const VectorRef& weights,
                                     const std::vector<std::string>& columns);

/// @param base  of the arm; the unknowns are its independent columns.
/// Source of the jackknife: Quenouille; Kuensch, Annals of Statistics 17(3), 1989 (blocks for dependent
/// data).
BaseSolution solve_base(const std::vector<CompressedRecording>& recordings,
                        const VectorRef& weights, const BaseParameters& base,
                        const std::vector<std::string>& names);

/// Sets clusters, scatter and std from the estimates (base x clusters) that each leave one cluster out.
void set_deviations(const MatrixXd& without, BaseSolution& solution);

/// 1 / (max - min) of every joint's torque over all recordings; one if the torque never changes.
VectorXd range_weights(const std::vector<CompressedRecording>& recordings);

/// 1 / standard deviation of every joint's residual in the fit with the weights `start`: one step of feasible
/// generalised least squares. It must not start from equal weights: where joints share parameters, they fit a
/// joint with small torques badly, and its weight would stay small.
/// @param joints  joint_totals().
VectorXd residual_weights(const std::vector<SquareRootInformation>& joints,
                          const VectorRef& start, const BaseParameters& base,
                          const std::vector<std::string>& names);

}  // namespace veridyn
