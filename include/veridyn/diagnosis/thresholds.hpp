#pragma once

#include <string>
#include <vector>

namespace veridyn {

/// Thresholds of a diagnosis before and after its search; those of the search are in src/diagnosis/search/numbers.hpp. threshold_table() gives the inequality and the reason of each;
/// `veridyn-hide-and-seek --set NAME=VALUE` runs the benchmark with another value.
struct Thresholds {
  // Comparison of fits.
  double smallest_gain = 0.04;
  double smallest_change = 0.1;
  double significance = 0.05;
  double tie = 0.95;
  double held_out_worse = 0.02;
  double main_share = 0.9;
  double negative_friction = 6.0;
  // Dependences without a named cause.
  double unnamed_share = 0.2;
  double line_of_motion = 0.5;
  // Smallest motion.
  double still_revolute = 5e-3;
  double still_prismatic = 5e-4;
  double moving_share = 0.02;
  double shortest_rest = 1.0;
  double move_as_one = 0.999;

  /// Largest travel of a joint that counts as at rest, rad or m.
  double still(bool prismatic) const { return prismatic ? still_prismatic : still_revolute; }
};

/// Inequality and reason of one threshold.
struct ThresholdEntry {
  std::string name;
  double Thresholds::* value;
  std::string inequality;  ///< condition, with its consequence
  std::string reason;      ///< reason for the value
};

/// The table of all thresholds, in the order of the struct.
const std::vector<ThresholdEntry>& threshold_table();

/// The entry with this name. @throws InvalidInput  it does not exist.
const ThresholdEntry& find_threshold(const std::string& name);

}  // namespace veridyn
