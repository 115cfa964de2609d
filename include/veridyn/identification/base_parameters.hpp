#pragma once

#include <string>
#include <vector>

#include "veridyn/regressor/standard_parameters.hpp"
#include "veridyn/math/square_root_information.hpp"

namespace veridyn {

/// Identifiability of one standard parameter: alone, in a combination, or not at all.
enum class Identifiability { kAlone, kInCombination, kNot };

/// The smallest set of parameters that the torques depend on:
///
///   beta = K * phi,   Y * phi = Y(:, independent) * beta
///
/// Row j of K has a one at independent[j]; its other entries regroup the dependent parameters.
/// Source: Gautier, J. Robotic Systems 8(4), 1991; thesis 5.1.
struct BaseParameters {
  std::vector<int> independent;  ///< indices of standard parameters, one for each base parameter
  MatrixXd K;                    ///< (base x standard)
  std::vector<Identifiability> classes;  ///< class of every standard parameter
  std::vector<std::string> names;        ///< "beta1 ..": named after the independent parameter
  std::vector<std::string> expressions;  ///< "m_tool + 0.25 m_counterweight"
  VectorXd singular_values;              ///< singular values of the scaled columns, largest first
  double rank_gap = 0.0;  ///< last kept over first dropped singular value; infinite if none was dropped

  int size() const { return static_cast<int>(independent.size()); }
};

/// Base parameters of the arm, from the regressor at random states within its limits (fixed seed).
BaseParameters base_parameters(const Model& arm);

/// Base parameters without those that are known by the robot file: the unknowns of an identification.
BaseParameters identifiable_base_parameters(const Model& arm);

/// Base parameters of any factor over standard parameters. Columns are scaled to norm one; singular values below
/// `tolerance` times the largest count as zero. Independent columns are chosen in the order of `preference`.
BaseParameters base_parameters(const SquareRootInformation& factor,
                               const std::vector<int>& preference, double tolerance = 1e-8);

/// The order in which columns are preferred: effects, then for every body first moments and inertias, masses last.
std::vector<int> preferred_columns(const std::vector<StandardParameter>& parameters);

/// The factor of the regressor at random states within the arm's limits; joints without limits move
/// within 1 rad or 0.1 m. For effects with memory the states are one trajectory.
/// @param still  names of coordinates that are held at rest.
SquareRootInformation random_state_factor(const Model& arm, int states, unsigned seed,
                                          const std::vector<std::string>& still = {});

/// Like random_state_factor(), with zero columns for known parameters, as in the factors of recordings.
SquareRootInformation identifiable_factor(const Model& arm, unsigned seed,
                                          const std::vector<std::string>& still = {});

}  // namespace veridyn
