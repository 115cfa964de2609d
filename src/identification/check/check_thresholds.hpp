#pragma once

#include <vector>

#include "math/number_table.hpp"
#include "veridyn/recordings/preprocessing.hpp"
#include "veridyn/recordings/recording_quality.hpp"

namespace veridyn {

/// All numbers that can change what `check` says about a recording beside a robot, each with its
/// inequality, and with its reason where one is known.
struct CheckThresholds {
  /// rows > most_rows: the rest is not read; 25 s at 200 Hz, and more rows add nothing new.
  int most_rows = 5000;
  /// rows < fewest_rows: no comparison with the robot; 1.5 s at 200 Hz determine no arm.
  int fewest_rows = 300;
  /// condition number < worst_condition, columns scaled, else no comparison; whole recordings of a PSM
  /// have 4600.
  double worst_condition = 2e4;
  /// The misfit is the sum over the joints of ln(unexplained share of a joint's squared torque), so that
  /// a joint that fits badly anyway does not hide another. Its fall > better: a question is answered by yes;
  /// as if one joint's share fell to 0.4 of its value.
  double better = 0.9;
  /// Fall of the misfit > gains_better: efforts are currents; drive gains differ little from joint to
  /// joint, and so do their fits.
  double gains_better = 0.3;
  /// what is left <= near_noise * the torque's white noise, or the rounding of its digits: nothing is to be asked, and
  /// what led there mends it. Friction near rest leaves a few times the noise on perfect recordings.
  double near_noise = 8.0;
  /// error left <= exact: rounding of six digits.
  double exact = 1e-5;
  /// relative error < smallest_share: counts as this; less is noise.
  double smallest_share = 1e-5;
  /// power lost to friction / (rms torque * rms speed) > friction_share: it has a sign.
  double friction_share = 0.03;
  /// the same > friction_above_rest * sqrt(unexplained share): what is not explained may do work of its own.
  double friction_above_rest = 0.3;
  /// relative rise of the rms misfit without friction > friction_significance; in the first seconds of a
  /// motion other parameters may absorb it. Recordings of a PSM have 0.27 to 2.3.
  double friction_significance = 0.25;
  /// A joint whose friction gives energy adds gives_energy to the misfit; more than `better`.
  double gives_energy = 1.5;
  /// unexplained share with the file's values < telling * that without: their ratio to the torques says something.
  double telling = 0.5;
  /// |ln(ratio)| > ln(torque_factor): the misfit grows by one for every further such factor, up to most_off, which is
  /// also what a ratio of the other sign adds.
  double torque_factor = 2.0, most_off = 3.0;
  /// position < lower - beyond_limits * range, or beyond the other end: outside of the joint's limits.
  double beyond_limits = 0.05;
  /// questions answered together <= most_together.
  int most_together = 4;
  /// polish of a direction: steps halve until < finest [rad].
  double finest = 4e-3;
};

/// All numbers, in the order of the struct.
const std::vector<TableNumber<CheckThresholds>>& check_numbers();

/// check_against() with other numbers.
std::vector<QualityFinding> check_against(const Model& arm, Recording recording, const PreprocessingOptions& options,
                                          const CheckThresholds& limits);

}  // namespace veridyn
