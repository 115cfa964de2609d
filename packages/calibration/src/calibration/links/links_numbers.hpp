#pragma once

namespace veridyn {

/// All numbers that can change what `calibrate links` names, each with its inequality and its reason.
struct LinksNumbers {
  /// frames >= fewest_frames: fewer poses hardly exceed the unknowns of a base and a tool.
  int fewest_frames = 10;
  /// median distance < near_position [m], median angle < near_angle [rad]: base and tool may be those of the file.
  double near_position = 0.05, near_angle = 0.08726646259971647;
  /// noise with the file's base and tool <= as_good * noise with free ones: the file's are kept.
  double as_good = 1.15;
  /// |error of an encoder's zero| < homed_angle [rad], homed_position [m]: it comes before constants that explain the poses
  /// as well. An arm that was homed by its marks has no larger one, and a constant of the file is the likelier cause.
  double homed_angle = 0.03490658503988659, homed_position = 0.005;
  /// gain >= rival * the best gain: poses cannot separate the two constants.
  double rival = 0.98;
  /// |change| > significant standard deviations: a named constant keeps its name, and base or tool is not the file's.
  double significant = 5.0;
  /// change <= misplaced * value of a named constant of the file: beyond, it is probably not the wrong one.
  double misplaced = 0.5;
  /// change of a named constant * preferred < change of a plain number: it is the likelier one.
  double preferred = 0.1;
  /// two deviations < loose_length [m], loose_angle [rad], loose_ratio: the parameter is worth a fit.
  double loose_length = 0.02, loose_angle = 0.05, loose_ratio = 0.2;
};

constexpr LinksNumbers links_numbers;

}  // namespace veridyn
