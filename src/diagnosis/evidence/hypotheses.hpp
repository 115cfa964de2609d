#pragma once

#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "diagnosis/candidates/candidates.hpp"
#include "diagnosis/evidence/numerics.hpp"
#include "veridyn/diagnosis/thresholds.hpp"
#include "veridyn/identification/compressed_recording.hpp"
#include "veridyn/regressor/standard_parameters.hpp"

namespace veridyn {

/// Index among a model's bodies.
struct BodyIndex {
  int value = 0;
};

/// A candidate with one choice of its shape constants, and its columns in a model.
struct Hypothesis : Candidate {
  Hypothesis() = default;
  explicit Hypothesis(Candidate c) : Candidate(std::move(c)) {}

  /// Owner of its columns in the augmented model: an effect, or a load's body.
  std::variant<TermIndex, BodyIndex> part;
  double reach = 1.0;  ///< A load's reach: largest distance [m] of its centre along each axis from the frame
  std::vector<std::string> columns;
  std::vector<ParameterSign> signs;
  std::vector<double> lowest;    ///< Least value of a change: less would make the parameter impossible
  double tried = 1.0;            ///< how many constants were looked at before this one was proposed
  bool repeats = true;  ///< several constants of it may act on one axis: memories, waves
  /// It depends on position or time, or is a sensor error: a single motion, in which many
  /// quantities are correlated, may mislead about it.
  bool extrapolates = false;
  double largest_value = numerics::kHuge;  ///< a parameter beyond this is unusual
  int stage =
      0;  ///< order of the questions: 0 channels, 1 inertia and elasticity, 2 friction and forces
};

/// True if the two differ in shape constants only.
inline bool same_candidate(const Candidate& a, const Candidate& b) {
  return a == b;
}

/// The arm with one more effect for every hypothesis; the effects' columns then come out of the
/// same pass as all others.
struct AugmentedModel {
  Model model;
  std::vector<Hypothesis> hypotheses;
};

/// Hypotheses to test.
struct CandidateList {
  std::vector<std::string> wanted;  ///< names of effects; empty: all
  /// The arm's values are facts: tests what changed since they were identified. Its own effects may
  /// have changed, and every link may have a payload.
  bool changes = false;
  std::vector<std::vector<double>> ripple_orders;  ///< per joint: ripple orders to test
  Thresholds limits;
  /// Asked beside the grid, first: terms whose constants are refined already. With their
  /// hypotheses.
  std::vector<std::pair<Hypothesis, EffectTerm>> known;
};

/// The effect of a hypothesis among those of its augmented model. Not of a load.
const EffectTerm& term_of(const Model& augmented, const Hypothesis& h);

/// Names of the standard parameters of its effect or its load.
std::vector<std::string> columns_in(const std::vector<StandardParameter>& all, const Hypothesis& h);

/// @param arm    with values, so that effects that depend on the load have one.
/// @param facts  of the training recordings: ranges of motion, for grids of lengths and speeds.
AugmentedModel augmented_model(const Model& arm, const std::vector<CompressedRecording>& facts,
                               const CandidateList& list);

}  // namespace veridyn
