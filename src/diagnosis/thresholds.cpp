#include "veridyn/diagnosis/thresholds.hpp"

#include <algorithm>

#include "veridyn/math/require.hpp"
#include "model/suggestion.hpp"

namespace veridyn {

const std::vector<ThresholdEntry>& threshold_table() {
  using T = Thresholds;
  static const std::vector<ThresholdEntry> kTable = {
      {"smallest_gain", &T::smallest_gain,
       "mean over folds of the fall of sum_j ln(held-out mean square) > smallest_gain: a velocity is derived from its "
       "position",
       "0.03 alone left 0.22 false names per diagnosis under periodic noise; a little above it, with "
       "the test of significance beside it"},
      {"smallest_change", &T::smallest_change,
       "the same of a velocity against a MODEL, and of a load > smallest_change",
       "a model's values are estimates, and what they leave over is no change: of 16 unchanged arms "
       "it left one false name of four; real changes gained 0.2 and more"},
      {"significance", &T::significance,
       "p < significance / number of causes or parameters that are compared",
       "the family-wise error rate of one diagnosis in twenty"},
      {"tie", &T::tie, "gain > tie * best gain: the link nearest to a load",
       "gains that differ by less are equal within the scatter between folds"},
      {"held_out_worse", &T::held_out_worse,
       "error after > (1 + held_out_worse) * error before: the extended model is worse on this joint",
       "errors of a joint that a finding does not concern move by a percent of themselves"},
      {"main_share", &T::main_share,
       "the first findings that explain main_share of what all explain are the main ones",
       "what a reader must see first"},
      {"negative_friction", &T::negative_friction,
       "standard deviations that a joint's friction lies below zero > negative_friction: its torque "
       "has the wrong sign",
       "friction is positive in any sound recording (an argument, not measured)"},
      {"unnamed_share", &T::unnamed_share,
       "share of the residual's mean square that a vibration takes on held-out recordings > unnamed_share: it is said",
       "a tenth of the residual's size: less is what filters and small wrong shapes leave"},
      {"line_of_motion", &T::line_of_motion,
       "share of a line in a signal of the motion > line_of_motion * that in the residual: it is no vibration",
       "a line that the motion has as well is what the model leaves of the motion"},
      {"still_revolute", &T::still_revolute, "travel [rad] > still_revolute: the joint moves",
       "friction holds a joint at rest against anything"},
      {"still_prismatic", &T::still_prismatic, "travel [m] > still_prismatic: the joint moves",
       "as above"},
      {"moving_share", &T::moving_share,
       "speed >= moving_share * the largest speed: the joint moves at this moment",
       "slower, its friction says nothing; the contract's share for errors of moving rows"},
      {"shortest_rest", &T::shortest_rest,
       "seconds at an end of a recording in which no joint moves > shortest_rest: left out",
       "friction at rest is any force: rests at the ends of 25 s came back as contacts and as warming up"},
      {"move_as_one", &T::move_as_one,
       "correlation of two positions > move_as_one: they are said to move as one",
       "above it a function of one position is one of the other within the accuracy of recordings"},
  };
  return kTable;
}

const ThresholdEntry& find_threshold(const std::string& name) {
  std::vector<std::string> names;
  for (const ThresholdEntry& entry : threshold_table()) {
    if (entry.name == name) return entry;
    names.push_back(entry.name);
  }
  throw InvalidInput(text("found the threshold '", name, "'", did_you_mean(name, names),
                          ", expected one of: ", listed(names), "."));
}

}  // namespace veridyn
