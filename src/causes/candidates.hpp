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

/// A cause that comes into question, whatever its constants. Diagnosis, watch and payload ask about
/// these and no others.
struct Candidate {
  Cause cause;
  std::optional<JointIndex> joint;  ///< acting_joint(); nothing: the whole arm
  Axis axis;                        ///< of an effect; zero where it is of the whole arm, and of a load
  std::optional<JointIndex> from;   ///< the coordinate that a coupling comes from
  /// The arm's own effect that has changed, or that has another constant than its file says. That
  /// one is no cause: accepted, it is a remark and no finding.
  std::optional<TermIndex> own = {};
  std::string signal = {};  ///< what a table is a function of; empty for all others
};

/// Candidates are values: equal where they are the same cause on the same axis, whatever constants
/// a hypothesis gives them.
bool operator==(const Candidate& a, const Candidate& b);
bool operator<(const Candidate& a, const Candidate& b);

bool is_load(const Candidate& c);
bool is_change(const Candidate& c);
bool is_other_constant(const Candidate& c);
bool is_channel(const Candidate& c);  ///< the error of a sensor, or of the arm as a whole

/// Which candidates there are.
struct Scope {
  std::vector<std::string> wanted;  ///< names; empty: all that are asked about of themselves
  /// The arm's values are facts: its own effects may have changed, and a load may sit on every link.
  bool changes = false;
  /// Of every joint whether it rests all the time; empty: none does. Friction holds a joint at rest
  /// against anything: its torque says nothing.
  std::vector<bool> still;
};

/// In the order of questions: errors of all channels and of the arm, what acts along each axis, loads.
std::vector<Candidate> candidates(const Model& arm, const Scope& scope);

/// Those that may begin while the arm moves: what every joint has and no day has from the day before,
/// sensor errors that begin suddenly, a load on these frames.
std::vector<Candidate> sudden_candidates(const Model& arm, const std::vector<FrameIndex>& loads);

/// What every joint has and what differs from one day to another, in the order of questions: a
/// zero, a level, a damping. A load must be told from them.
std::vector<std::string> elementary_effects();

/// Friction along an axis.
bool is_friction(const std::string& effect);

/// Frames on which a payload would make a difference: the last frame of every link that moves.
std::vector<FrameIndex> payload_frames(const Model& arm);

/// True if the two frames are fixed to one link.
bool same_link(const Model& arm, FrameIndex a, FrameIndex b);

}  // namespace veridyn
