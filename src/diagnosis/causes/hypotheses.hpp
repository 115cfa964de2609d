#pragma once

#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "diagnosis/numerics.hpp"
#include "veridyn/diagnosis/thresholds.hpp"
#include "veridyn/effects/cause.hpp"
#include "veridyn/identification/compressed_recording.hpp"
#include "veridyn/regressor/standard_parameters.hpp"

namespace veridyn {

/// Index among a model's effects, and among its bodies.
struct TermIndex {
  size_t value = 0;
};
struct BodyIndex {
  int value = 0;
};

/// One thing that may be missing in the model: an effect on one coordinate with one choice of its
/// shape constants, or a load on a link.
struct Hypothesis {
  Cause cause;
  std::optional<JointIndex> joint;  ///< acting_joint(); nothing: the whole arm
  /// What has its columns in the augmented model: an effect, or a load's body.
  std::variant<TermIndex, BodyIndex> part;
  double reach = 1.0;  ///< A load's reach: largest distance [m] of its centre along each axis from the frame
  /// The arm's own effect that has changed, or that has another constant than its file says. That
  /// one is no cause: accepted, it is a remark and no finding.
  std::optional<TermIndex> own;
  std::vector<std::string> columns;
  std::vector<ParameterSign> signs;
  std::vector<double> lowest;    ///< Least value of a change: less would make the parameter impossible
  double tried = 1.0;            ///< how many constants were looked at before this one was proposed
  bool repeats = true;  ///< several constants of it may act on one axis: memories, waves
  /// It depends on where the arm is or on the time, or is an error of a channel: one motion, in which
  /// much goes together, may mislead about it.
  bool extrapolates = false;
  double largest_value = numerics::kHuge;  ///< a parameter beyond this is unusual
  int stage =
      0;  ///< order of the questions: 0 channels, 1 inertia and elasticity, 2 friction and forces
  std::string family;  ///< hypotheses that differ in shape constants only share it
};

bool is_load(const Hypothesis& h);
bool is_change(const Hypothesis& h);
bool is_other_constant(const Hypothesis& h);

/// The arm with one more effect for every hypothesis; the effects' columns then come out of the
/// same pass as all others.
struct AugmentedModel {
  Model model;
  std::vector<Hypothesis> hypotheses;
};

/// What to ask.
struct QuestionList {
  std::vector<std::string> wanted;  ///< names of effects; empty: all
  /// The arm's values are facts: ask what changed since they were identified. Its own effects may
  /// have changed, and a payload may sit on every link.
  bool changes = false;
  std::vector<std::vector<double>> ripple_orders;  ///< per joint: waves to ask about
  Thresholds limits = {};
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
                               const QuestionList& list);

/// What every joint has and what differs from one day to another, in the order of questions: a
/// zero, a level, a damping. A load must be told from them.
std::vector<std::string> elementary_effects();

/// Frames on which a payload would make a difference: the last frame of every link that moves.
std::vector<int> payload_frames(const Model& arm);

/// True if the two frames are fixed to one link.
bool same_link(const Model& arm, int a, int b);

}  // namespace veridyn
