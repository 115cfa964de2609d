#pragma once

#include <string>
#include <vector>

namespace veridyn {

/// All numbers that can change a verdict of a diagnosis. threshold_table() gives the inequality and
/// the reason of each; `veridyn-hide-and-seek --set NAME=VALUE` plays a board at another value.
struct Thresholds {
  // Selection of causes.
  double smallest_gain = 0.04;
  double smallest_change = 0.1;
  double significance = 0.05;
  double tie = 0.95;
  double rival_share = 0.8;
  double own_cause = 0.5;
  double rival_same_joint = 0.4;
  double rival_elsewhere = 0.6;
  double refuting = 0.1;
  double tested_candidates = 6.0;
  double corrected_channels = 4.0;
  double settling = 6.0;
  double new_share = 1e-6;
  double fewest_folds = 4.0;
  double compact_load = 0.8;
  double impossible_fall = 1.2;
  double held_out_worse = 0.02;
  double main_share = 0.9;
  double negative_friction = 6.0;
  // Dependences without a named cause.
  double unnamed_gain = 0.05;
  double unnamed_terms = 4.0;
  double unnamed_share = 0.2;
  double unnamed_share_of_one = 0.4;
  double unnamed_term = 0.05;
  double small_beside_unnamed = 0.1;
  double unnamed_other_joint = 0.93;
  double unnamed_two_signals = 0.85;
  double at_floor = 1.15;
  double withdrawals = 3.0;
  // Smallest motion.
  double still_revolute = 5e-3;
  double still_prismatic = 5e-4;
  double moving_share = 0.02;
  double shortest_rest = 1.0;
  double move_as_one = 0.999;
  // Wrong constants of the robot file.
  double constant_gain = 2.0;
  double kept_constants = 5.0;
  double constant_rivals = 5.0;
  double constant_sharpness = 0.4;
  double commoner_cause = 0.93;
  double weaker_rival = 0.3;
  // Ripple of a torque along the travel.
  double ripple_waves = 3.0;
  double ripple_finest = 600.0;
  double ripple_prominence = 4.0;
  // Contacts.
  double contact_threshold = 5.0;
  double contact_peak = 8.0;
  double contact_direction = 0.3;
  double contact_torque_share = 0.04;
  double contact_rest_share = 1.6;
  double contact_shortest = 0.3;
  double contact_most_of_time = 0.5;
  double contact_per_minute = 12.0;
  double contact_always = 5.0;
  double contact_repeats = 0.4;
  // Local sticking in a single recording.
  double snag_prominence = 6.0;
  double snag_torque_share = 0.2;
  double snag_widest = 0.4;

  /// Largest travel of a joint that counts as at rest, rad or m.
  double still(bool prismatic) const { return prismatic ? still_prismatic : still_revolute; }
};

/// Role of one of these numbers.
struct ThresholdEntry {
  std::string name;
  double Thresholds::* value;
  std::string inequality;  ///< inequality that holds for the first of the two verdicts
  std::string reason;      ///< reason for the value
  std::string seeds;       ///< seeds of hide-and-seek on which it was chosen; empty: none
};

/// The table of all thresholds, in the order of the struct.
const std::vector<ThresholdEntry>& threshold_table();

/// The entry of that name. @throws InvalidInput  it does not exist.
const ThresholdEntry& find_threshold(const std::string& name);

}  // namespace veridyn
