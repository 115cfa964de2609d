#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "diagnosis/numerics.hpp"
#include "veridyn/diagnosis/thresholds.hpp"
#include "veridyn/identification/compressed_recording.hpp"

namespace veridyn {

/// One thing that may be missing in the model: an effect on one coordinate with one choice of its
/// shape constants.
struct Hypothesis {
  std::string effect;
  int joint = 0;       ///< coordinate, from 0; -1: the whole arm
  int term = -1;       ///< index among the augmented model's effects; -1: a payload
  int frame = -1;      ///< A payload's link: its frame in the arm asked about
  int body = -1;       ///< A payload's index among the augmented model's bodies
  double reach = 1.0;  ///< A payload's reach: largest distance [m] of its centre along each axis from the frame
  int changes = -1;    ///< index of the arm's own effect that has changed; -1: a new one
  /// Index of the arm's own effect that this is, with another constant; -1: none. The model has the
  /// effect: accepted, it is a remark and no finding.
  int instead_of = -1;
  std::vector<std::string> columns;
  std::vector<ParameterSign> signs;
  std::vector<double> lowest;    ///< Least value of a change: less would make the parameter impossible
  double tried = 1.0;            ///< how many constants were looked at before this one was proposed
  bool repeats = true;  ///< several constants of it may act on one axis: memories, waves
  bool extrapolates = false;     ///< it depends on where the arm is: one motion may mislead
  double largest_value = numerics::kHuge;  ///< a parameter beyond this is unusual
  int stage =
      0;  ///< order of the questions: 0 channels, 1 inertia and elasticity, 2 friction and forces
  std::string family;  ///< hypotheses that differ in shape constants only share it
};

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
