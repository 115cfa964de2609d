#pragma once

#include <optional>
#include <string>
#include <vector>

#include "veridyn/effects/cause.hpp"
#include "veridyn/effects/effect.hpp"

namespace veridyn {

/// Index among a model's effects.
struct TermIndex {
  size_t value = 0;
};

/// A possible cause, independent of shape constants. Diagnosis and watch test these candidates and no others.
struct Candidate {
  Cause cause;
  std::optional<JointIndex> joint;  ///< acting_joint(); nothing: the whole arm
  Axis axis;                        ///< axis of an effect; zero for an effect of the whole arm and for a load
  std::optional<JointIndex> from;   ///< second coordinate of a coupling
  /// Index of the arm's own effect, if the candidate is a change of it. Where only a constant differs from
  /// the file, an accepted candidate becomes a remark and no finding.
  std::optional<TermIndex> own = {};
};

bool is_load(const Candidate& c);  ///< a load on a frame
bool is_changed_effect(const Candidate& c);  ///< other values of an effect that the arm has
bool is_changed_constant(const Candidate& c);  ///< another shape constant of an effect that the arm has
bool is_channel(const Candidate& c);  ///< the error of a sensor, or of the arm as a whole

/// Selection of candidates.
struct Scope {
  std::vector<std::string> wanted;  ///< names; empty: all that are tested by default
  /// True if the arm's values are facts: its own effects may have changed, and any link may carry a load.
  bool changes = false;
  /// True for every joint that is always at rest; empty if none is. The torque of such a joint carries no
  /// information, because friction at rest is undetermined.
  std::vector<bool> still;
};

/// The candidates in the order of the tests: errors of all channels and of the arm, effects along
/// each axis, loads.
std::vector<Candidate> candidates(const Model& arm, const Scope& scope);

/// Candidates that may begin while the arm moves: effects of every joint that vary from day to day,
/// sensor errors that begin suddenly, a load on these frames.
std::vector<Candidate> sudden_candidates(const Model& arm, const std::vector<FrameIndex>& loads);

/// True for friction along an axis.
bool is_friction(const std::string& effect);

/// Frames on which a payload can be distinguished from payloads on others: the last frame of every link that moves.
std::vector<FrameIndex> payload_frames(const Model& arm);

/// True if the two frames are fixed to one link.
bool same_link(const Model& arm, FrameIndex a, FrameIndex b);

}  // namespace veridyn
