#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "veridyn/identification/identification.hpp"
#include "veridyn/identification/rest_poses.hpp"
#include "veridyn/identification/verdict.hpp"

namespace veridyn {

/// All numbers that can change the report or the model of `identify`, outside of the feasible solver. Each
/// comment gives the condition, then its consequence, and the reason where one is known.
struct IdentificationNumbers {
  // Motion of joints.
  /// travel of a joint < still_revolute [rad], still_prismatic [m]: it never moves, and the arm is not
  /// determined.
  double still_revolute = 2e-3, still_prismatic = 2e-4;

  // Velocities.
  /// decrease of ln(mean squared error) of a joint's torque > velocity_gain: its velocity is derived from the
  /// position; this is 2 % of the error.
  double velocity_gain = 0.04;

  // Verdicts on joints.
  /// error <= far_above_floor * floor: the joint is at its noise floor. Beyond twice, more than three quarters
  /// of the squared residual is no noise; floors from repeats include some variation from period to period.
  double far_above_floor = 2.0;
  /// error <= below_any_sensor, a share of the torque: the joint is at its noise floor; 1 % is better than any
  /// torque sensor.
  double below_any_sensor = 0.01;
  /// share of the range and of the speed < hardly_moves: the joint has to be recorded again.
  double hardly_moves = kHardlyMovingShare;
  /// largest torque of each joint < no_torque [N m], [N]: no torque was recorded. No sensor resolves so little,
  /// and tolerances for rounding matter from 1e-16 on.
  double no_torque = 1e-12;
  /// distance between samples > adjacent [s]: a gap, across which repeats are not compared.
  double adjacent = 0.05;
  /// share of a recording's samples in gaps or beside them < few_in_gaps: not reported.
  double few_in_gaps = 1e-3;

  /// share of a test recording's rows that a training recording holds as well >= learned_rows: it is not held out. With
  /// one joint and coarse registers one row in eighty follows three equal rows by chance.
  double learned_rows = 0.1;

  // Standard deviations.
  /// blocks of a recording <= most_blocks, phases of a period = phases: enough for a jackknife, and long
  /// compared with the correlation time of the residuals.
  int most_blocks = 16, phases = 8;
  /// blocks of all recordings together <= blocks_of_all, one at least of each: 10 recordings keep 16 each,
  /// 16 recordings eight, 100 one.
  int blocks_of_all = 160;
  /// duration of a block >= first_block [s]; it is doubled whenever there are too many blocks.
  double first_block = 1.0;
  /// time at the beginning in which a period is sought <= period_time [s].
  double period_time = 125.0;

  // Rests.
  /// |dq| <= still_turning [rad/s], still_sliding [m/s] for >= fewest_rows rows: the arm is at rest; fewer rows
  /// are a reversal.
  double still_turning = 5e-3, still_sliding = 1e-3;
  int fewest_rows = 5;
  /// singular value <= rest_rank * the largest: poses that hardly differ determine nothing.
  double rest_rank = 1e-6;

  // Gains of drives from a known mass.
  /// half the 95 % interval < identifiable * |gain|, else the gain is not identifiable.
  double identifiable = 0.25;
  /// t value of some joint >= heavier, else the recordings do not show the mass.
  double heavier = 4.0;
  /// clusters >= fewest_clusters, else the recordings do not show the mass either.
  int fewest_clusters = 3;
  /// share of a joint's torque by the mass < unloaded: the mass does not act on it.
  double unloaded = 1e-6;
  /// recordings <= most_divisions: all divisions into loaded and free ones are tried.
  int most_divisions = 8;
  /// share of a gain's column outside the span of the others < untied: rounding; the mass does not determine
  /// this gain.
  double untied = 1e-6;

  // Recordings.
  /// remaining error > outstanding * that of another recording of the command: the recording may have a mistake of its own.
  double outstanding = 3.0;
};

/// Numbers that change no result: definitions of printed figures, memory, and safe arithmetic.
namespace identifying {

constexpr IdentificationNumbers numbers;

// Definitions.
/// speed > kMovingShare * the joint's largest: the row counts as moving; its error is reported separately
/// (docs/contract.md).
constexpr double kMovingShare = 0.02;
constexpr double kHardlyTorque = 1e-4;    ///< [N m], [N] torque below what any arm's drives show
constexpr std::size_t kShownAtEdge = 4;   ///< active bodies and bounds listed in the text; the JSON has all
constexpr double kBand = 0.95;             ///< share of the poses within the printed band

// Texts.
constexpr double kOutside = 0.05;          ///< probability outside of a printed interval
constexpr double kNormal95 = 1.96;         ///< half width of a normal 95 % interval, in standard deviations
constexpr double kLoud = 0.05;             ///< floors above this share of the torque are called differences of repetitions, not noise
/// noise floor of a recording > kOnce * the smallest of all recordings: something in it does not repeat, and it is left out of the mean.
constexpr double kOnce = 3.0;
constexpr double kLargestRatio = 1000.0;   ///< larger ratios of error to floor are printed as "over 1000"
constexpr double kBandSteps = 1e4;         ///< steps per N m or N that a printed band is rounded to
constexpr double kSolving = 0.4;           ///< share of the work done after reading
constexpr double kValidating = 0.6;        ///< share of the work done after solving

// Memory.
constexpr long kPeriodRows = 8192;         ///< largest number of rows in which a period is sought; more are thinned
constexpr int kPieceRows = 2048;           ///< rows that are read at once
constexpr int kRestPiece = 4096;           ///< rows that are read at once in a search for poses at rest
/// blocks of a recording that memory leaves >= kFewestBlocks
constexpr int kFewestBlocks = 4;
constexpr double kMostBytes = 256.0 * 1024.0 * 1024.0;  ///< memory of one recording's factors
constexpr std::size_t kGroupsAtOnce = 16;  ///< groups of joints whose factors are in memory together
constexpr long kLookedAt = 20000;          ///< rows of a recording from which units and noise of velocities are judged
constexpr int kSeriesSamples = 15000;      ///< samples of the series for plots, of all recordings together
constexpr int kFewestSamples = 100;        ///< samples of the series for plots that each recording keeps

// Arithmetic.
/// part of a base parameter outside the span of the data's > kOutsideSpan of it: more than rounding; 1e-8 and
/// 1e-2 give the same results
constexpr double kOutsideSpan = 1e-5;
/// torque of a kilogram on a joint > kNoWeight [N m/kg]: more than rounding; 1e-12 and 1e-6 give the same
/// results
constexpr double kNoWeight = 1e-9;
constexpr double kDependentColumn = 1e-9;  ///< smaller pivots: the column is a combination of others up to rounding
constexpr double kBelowNyquist = 0.45;     ///< share of the sample rate below which positions of instruments are filtered
constexpr double kEndOfTime = 0.999999;    ///< largest time, as a share of a recording, that lies inside its last segment
constexpr int kSpeeds = 30;                ///< speeds of a friction curve in either direction
constexpr int kRun = 60;                   ///< steps that friction with a memory slides before its force is read
constexpr double kRunSeconds = 2.0;        ///< [s] duration of those steps
constexpr int kStates = 200;               ///< random states at which columns of drive gains are compared
constexpr int kIterations = 60;            ///< largest number of Levenberg-Marquardt steps of the drive gains
constexpr double kConverged = 1e-12;       ///< relative fall of the cost at which that search ends
constexpr double kFirstDamping = 1e-6;     ///< initial damping of that search
constexpr double kLeastDamping = 1e-14;    ///< smallest damping of that search
constexpr double kMostDamping = 1e6;       ///< largest damping of that search: no step succeeds
constexpr double kDampingUp = 10.0;        ///< factor of the damping after a step that fails; its inverse after a success
constexpr double kLeastNoise = 1e-9;       ///< smallest noise, as a share of a joint's currents; no division by
                                           ///< zero
constexpr double kNoScale = 1e-9;          ///< gains below this share of the largest one count as zero
// A solid ball stands in for moments of inertia that poses at rest cannot determine.
constexpr double kBallMass = 1.0;          ///< [kg] mass of the ball
constexpr double kBallRadius = 0.1;        ///< [m] radius of the ball
constexpr double kSolidBall = 0.4;         ///< moment of inertia over mass and squared radius

}  // namespace identifying
}  // namespace veridyn
