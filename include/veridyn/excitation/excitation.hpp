#pragma once

#include <functional>
#include <string>
#include <vector>

#include "veridyn/excitation/fourier_trajectory.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// What a good motion is.
enum class ExcitationCriterion {
  /// Smallest condition number of the base regressor, columns scaled to norm one (thesis 5.27).
  kCondition,
  /// Largest ln det of its Gram matrix: the smallest volume of the confidence ellipsoid.
  kDOptimal,
};

/// "condition", "d-optimal".
const char* name_of(ExcitationCriterion criterion);

struct ExcitationOptions {
  double frequency = 0.13;  ///< [Hz] of the fundamental wave
  int harmonics = 5;        ///< at least 2: one alone cannot start at rest
  double duration = 30.0;   ///< [s] wanted; rounded to whole periods, at least two
  double rate = 200.0;      ///< [Hz] of the samples
  ExcitationCriterion criterion = ExcitationCriterion::kCondition;
  int starts = 4;  ///< independent searches, of which the best wins
  /// Of the criterion in each search; the result depends on this and not on the clock.
  int evaluations = 1500;
  /// Of the range, the speed and the acceleration that may be used, above 0 and at most 1.
  double limit_share = 0.95;
  unsigned seed = 1;
  int threads = 0;  ///< of the searches; 0: one per core; no matter for the result
  /// Called with (what is being done, share done) from the calling thread.
  std::function<void(const std::string&, double)> progress;
};

enum class ExcitationStatus {
  kDone,
  kRankDeficient,  ///< no motion was found that excites all base parameters; the best one is given
};

/// An excitation trajectory and how good it is.
struct Excitation {
  ExcitationStatus status = ExcitationStatus::kDone;
  std::string robot;
  ExcitationCriterion criterion = ExcitationCriterion::kCondition;
  FourierTrajectory trajectory;
  int periods = 0;
  int base_parameters = 0;
  double condition_number = 0.0;  ///< of the base regressor, columns scaled to norm one
  /// Of its Gram matrix per instant, columns scaled by their size at random states.
  double log_determinant = 0.0;
  double start_condition_number = 0.0;  ///< of the first random motion, for comparison
  long evaluations = 0;
  MotionBounds bounds{};              ///< of the motion
  MotionBounds limits{};              ///< of the arm, in the same order
  std::vector<std::string> joints{};  ///< names of the coordinates
  std::vector<std::string> units{};   ///< "rad" or "m"

  /// Status, quality and margins to the limits, as text.
  std::string report() const;
};

/// Searches a Fourier trajectory that starts and stops at rest, repeats its period, keeps within
/// the limits of the arm (between samples as well) and excites its base parameters.
///
/// Random multi-start, then a random local search with step-size control (the one-fifth rule:
/// Rechenberg, Evolutionsstrategie, 1973). Every candidate is scaled to the limits, so that all are
/// feasible. The regressor is taken at 150 instants of one period. Cost: about 1 ms per evaluation
/// for six joints.
/// @throws InvalidInput  an option is out of range.
Excitation optimise_excitation(const Model& arm, const ExcitationOptions& options = {});

}  // namespace veridyn
