#pragma once

namespace veridyn {

/// All numbers that can change the constants that `calibrate links` reports, each with its inequality and its
/// reason.
struct LinksNumbers {
  /// frames >= fewest_frames: with fewer poses there are hardly more equations than unknowns of base and
  /// tool.
  int fewest_frames = 10;
  /// median distance < near_position [m], median angle < near_angle [rad]: base and tool may be at the file's
  /// poses.
  double near_position = 0.05, near_angle = 0.08726646259971647;
  /// noise with the file's base and tool <= as_good * noise with free ones: the file's are kept.
  double as_good = 1.15;
  /// |error of an encoder's zero| < homed_angle [rad], homed_position [m]: it is preferred to other constants
  /// that explain the poses equally well. Homing by marks leaves no larger error; beyond it, a constant of
  /// the file is the likelier cause.
  double homed_angle = 0.03490658503988659, homed_position = 0.005;
  /// gain >= rival * the best gain: poses cannot separate the two constants.
  double rival = 0.98;
  /// |change| > significant standard deviations: a named constant is reported, and base or tool differs from
  /// the file.
  double significant = 5.0;
  /// change <= misplaced * value of a named constant of the file: with a larger change it is probably not the
  /// wrong one.
  double misplaced = 0.5;
  /// change of a named constant * preferred < change of a plain number: the named constant is the likelier
  /// cause.
  double preferred = 0.1;
  /// two deviations < loose_length [m], loose_angle [rad], loose_ratio: the parameter is worth fitting.
  double loose_length = 0.02, loose_angle = 0.05, loose_ratio = 0.2;
};

constexpr LinksNumbers links_numbers;

}  // namespace veridyn
