#include "veridyn/diagnosis/thresholds.hpp"

#include <algorithm>

#include "veridyn/math/require.hpp"
#include "model/suggestion.hpp"

namespace veridyn {

// Seeds are those of `veridyn-hide-and-seek` on which the number was chosen. "not recorded" means
// that they were not written down: the reason is then an argument and no measurement. Numbers without seeds
// follow from the meaning of the quantity, or from the recordings that the reason names.
constexpr const char* kNotRecorded = "not recorded";

const std::vector<ThresholdEntry>& threshold_table() {
  using T = Thresholds;
  static const std::vector<ThresholdEntry> kTable = {
      {"smallest_gain", &T::smallest_gain,
       "mean over folds of the fall of sum_j ln(held-out mean square) > smallest_gain; half of it at the "
       "first step of a constant's profile",
       "0.03 alone left 0.22 false names per diagnosis under periodic noise; a little above it, with "
       "the test of significance beside it",
       kNotRecorded},
      {"smallest_change", &T::smallest_change,
       "the same of an arm with values (a MODEL) > smallest_change",
       "a model's values are estimates, and what they leave over is no change: of 16 unchanged arms "
       "it left one false name of four; real changes gained 0.2 and more",
       kNotRecorded},
      {"significance", &T::significance,
       "p of the parameters over clusters < significance / number of causes asked",
       "the family-wise error rate of one diagnosis in twenty; the folds' signed ranks are asked at "
       "this level too",
       ""},
      {"tie", &T::tie, "gain > tie * best gain: the earlier question wins",
       "gains that differ by less are equal within the scatter between folds", kNotRecorded},
      {"rival_share", &T::rival_share,
       "gain >= rival_share * best gain: tested as well; a constant must reach it; a branch with it "
       "goes before the longest chain",
       "rivals within 20 % of the gain are a tie on the thesis's arm; a wrong angle between branches "
       "can be corrected in either",
       ""},
      {"own_cause", &T::own_cause,
       "gain beside the finding < own_cause * gain in its place: a rival, else a cause of its own",
       "a cause that keeps half of its gain explains something else", kNotRecorded},
      {"rival_same_joint", &T::rival_same_joint,
       "gain in its place >= rival_same_joint * own gain: listed, same joint",
       "a rival that gains less is no help to the reader (an argument, not measured)", kNotRecorded},
      {"rival_elsewhere", &T::rival_elsewhere,
       "gain in its place >= rival_elsewhere * own gain: listed, another joint",
       "farther causes need to come nearer to be worth an experiment", kNotRecorded},
      {"refuting", &T::refuting,
       "gain of the finding beside the rival > refuting: the rival is refuted",
       "encompassing: what the finding explains beyond its rival must be well above smallest_gain",
       kNotRecorded},
      {"tested_candidates", &T::tested_candidates, "rank of the gain < tested_candidates: Wald test",
       "the test costs a fit per cluster; no true cause stood farther back", kNotRecorded},
      {"corrected_channels", &T::corrected_channels,
       "errors of channels corrected one after the other <= corrected_channels",
       "each asks everything anew; recordings with more have another fault", ""},
      {"settling", &T::settling,
       "findings that lose their names after the last fit <= settling",
       "each is a fit of the arm; the rest stays listed as not confirmed", ""},
      {"new_share", &T::new_share,
       "share of a column's square that the others do not span > new_share",
       "below it the data cannot answer: half of the digits of a double", ""},
      {"fewest_folds", &T::fewest_folds,
       "held-out parts >= fewest_folds: one of them may disagree; recordings are divided into so many, a single "
       "one into twice as many",
       "a recording can have a fault of its own; one of three is no exception", ""},
      {"compact_load", &T::compact_load,
       "share of what ten columns of a load explain that a point mass explains >= compact_load",
       "0.93 and more where there was a load, often below 0.6 where there was none, on 40 arms",
       kNotRecorded},
      {"impossible_fall", &T::impossible_fall,
       "a changed parameter's fall <= impossible_fall * its value",
       "friction cannot fall below nothing; a fifth is left to the error of both values", ""},
      {"held_out_worse", &T::held_out_worse,
       "error after > (1 + held_out_worse) * error before: the extended model is worse on this joint",
       "errors of a joint that a finding does not concern move by a percent of themselves", ""},
      {"main_share", &T::main_share,
       "the first findings that explain main_share of what all explain are the main ones",
       "what a reader must see first", ""},
      {"negative_friction", &T::negative_friction,
       "standard deviations that a joint's friction lies below zero > negative_friction: its torque "
       "has the wrong sign",
       "friction is positive in any sound recording (an argument, not measured)", ""},
      {"unnamed_gain", &T::unnamed_gain,
       "mean over folds of the fall of ln(held-out mean square of one joint's residual) > unnamed_gain: "
       "one more smooth term",
       "the best of some hundred smooth terms gains 0.02 to 0.03 on coloured noise of 100 s", ""},
      {"unnamed_terms", &T::unnamed_terms, "smooth terms of one joint < unnamed_terms: one more is sought",
       "each costs a search of some hundred", ""},
      {"unnamed_share", &T::unnamed_share,
       "share of the residual's mean square that smooth terms predict on held-out folds > unnamed_share: a "
       "finding without a name",
       "a tenth of the residual's size: less is what filters and small wrong shapes leave", ""},
      {"unnamed_share_of_one", &T::unnamed_share_of_one,
       "the same where one recording is all there is to learn from > unnamed_share_of_one",
       "along one path every signal is a function of time: of ten such dependences with 12 to 34 % on the "
       "recordings of a PSM's wrist, an MTM and a Panda the held-out recording bore out two",
       ""},
      {"unnamed_term", &T::unnamed_term,
       "share of the residual's mean square that one more term predicts on held-out folds >= unnamed_term: a "
       "finding of its own",
       "a fortieth of the residual's size is left in the regression and not spoken of", ""},
      {"small_beside_unnamed", &T::small_beside_unnamed,
       "mean square that a name takes on its joint < small_beside_unnamed * what smooth terms take there: "
       "not confirmed",
       "a force of another shape that is ten times as large bends whatever is fitted beside it", ""},
      {"unnamed_other_joint", &T::unnamed_other_joint,
       "gain of another joint's signal * unnamed_other_joint > gain of the joint's own: it is taken",
       "signals of one motion go together, and a joint's own are the likelier cause", ""},
      {"unnamed_two_signals", &T::unnamed_two_signals,
       "gain of two signals * unnamed_two_signals > gain of one: they are taken",
       "a function of two signals holds those of each", ""},
      {"at_floor", &T::at_floor, "error held out <= at_floor * floor: the joint is at its floor",
       "noise floors from repeats differ by a tenth from one recording to the next", ""},
      {"withdrawals", &T::withdrawals,
       "rounds in which names were withdrawn < withdrawals: another one",
       "each round is a fit of the arm", "1"},
      {"still_revolute", &T::still_revolute, "travel [rad] > still_revolute: the joint moves",
       "friction holds a joint at rest against anything", ""},
      {"still_prismatic", &T::still_prismatic, "travel [m] > still_prismatic: the joint moves",
       "as above", ""},
      {"moving_share", &T::moving_share,
       "speed >= moving_share * the largest speed: the joint moves at this moment",
       "slower, its friction says nothing; the contract's share for errors of moving rows", ""},
      {"shortest_rest", &T::shortest_rest,
       "seconds at an end of a recording in which no joint moves > shortest_rest: left out",
       "friction at rest is any force: rests at the ends of 25 s came back as contacts and as warming up", ""},
      {"move_as_one", &T::move_as_one,
       "correlation of two positions > move_as_one: they are said to move as one",
       "above it a function of one position is one of the other within the accuracy of recordings", ""},
      {"constant_gain", &T::constant_gain,
       "gain of a wrong constant >= constant_gain * smallest_gain",
       "some hundred constants are looked at before one is proposed", kNotRecorded},
      {"kept_constants", &T::kept_constants,
       "rank of a constant's gain < kept_constants: the wrong one, or listed as its rival",
       "more are no help to the reader", ""},
      {"constant_rivals", &T::constant_rivals, "rivals of a constant <= constant_rivals: an effect is listed as one more",
       "more are no help to the reader", ""},
      {"constant_sharpness", &T::constant_sharpness,
       "the mirrored value is worse by more than constant_sharpness * gain",
       "improvement with both signs is flexibility and no wrong constant (thesis's arm)", ""},
      {"commoner_cause", &T::commoner_cause,
       "gain of an encoder's zero or of a tilt > commoner_cause * gain of the constant: it goes first",
       "an angle of the table and the zero of its encoder do the same; the zero is commoner",
       kNotRecorded},
      {"weaker_rival", &T::weaker_rival,
       "gain of an effect >= weaker_rival * gain of the constant: listed as its rival",
       "asked alone it hides the constant", ""},
      {"ripple_waves", &T::ripple_waves, "waves per travel >= ripple_waves",
       "fewer look like any smooth function of position", ""},
      {"ripple_finest", &T::ripple_finest, "waves per travel < ripple_finest",
       "gears of 100 with two waves per turn, three turns; also the number of orders looked at, by "
       "which the significance of a ripple is divided",
       ""},
      {"ripple_prominence", &T::ripple_prominence,
       "amplitude >= ripple_prominence * median of the spectrum",
       "of 1200 amplitudes of noise one exceeds 3.3 medians", ""},
      {"contact_threshold", &T::contact_threshold,
       "residual > contact_threshold * its scatter elsewhere: a burst begins",
       "five standard deviations of what is left over without contacts", kNotRecorded},
      {"contact_peak", &T::contact_peak, "largest residual >= contact_peak * its scatter",
       "a push is seen without doubt", kNotRecorded},
      {"contact_direction", &T::contact_direction,
       "|mean residual| >= contact_direction * largest: it pushes to one side",
       "friction at a reversal swings to both sides", kNotRecorded},
      {"contact_torque_share", &T::contact_torque_share,
       "residual > contact_torque_share * the joint's largest torque",
       "smaller bursts are friction at rest (UR10e)", ""},
      {"contact_rest_share", &T::contact_rest_share,
       "residual > contact_rest_share * friction of a joint at rest",
       "friction at rest holds up to its whole level on either side; the UR10e's more", ""},
      {"contact_shortest", &T::contact_shortest, "duration [s] >= contact_shortest",
       "the low-pass smears anything shorter", ""},
      {"contact_most_of_time", &T::contact_most_of_time,
       "share of the recording in bursts <= contact_most_of_time",
       "more is no moment", ""},
      {"contact_per_minute", &T::contact_per_minute, "contacts per minute <= contact_per_minute",
       "more belong to the motion", ""},
      {"contact_always", &T::contact_always, "contacts of a recording <= contact_always: allowed, however short it is",
       "a few pushes are no property of the motion", ""},
      {"contact_repeats", &T::contact_repeats,
       "residual at the same phase of another period, or at the same place in most passes <= contact_repeats * size",
       "what comes back with the motion is a property of the arm", kNotRecorded},
      {"snag_prominence", &T::snag_prominence,
       "extra friction of one place > snag_prominence * its scatter between recordings",
       "files 1 and 6 of the thesis stand out (an argument, not measured)", ""},
      {"snag_torque_share", &T::snag_torque_share,
       "extra friction > snag_torque_share * the joint's rms torque",
       "smaller friction may be anything", ""},
      {"snag_widest", &T::snag_widest, "width <= snag_widest * travel",
       "wider is friction of its own", ""},
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
