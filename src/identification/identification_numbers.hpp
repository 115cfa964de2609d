#pragma once

#include <cstddef>

/// Numbers of `identify` outside of the feasible solver. Those of the first part can change what it says
/// or which model it gives; each has its inequality, and its reason where one is known. Those of the
/// second part bound memory, or keep arithmetic sound.
namespace veridyn::identifying {

// Which joints move, and where.
/// travel of a joint < kStillRevolute [rad] or kStillPrismatic [m]: it never moves, and the arm is not
/// determined.
constexpr double kStillRevolute = 2e-3, kStillPrismatic = 2e-4;
/// speed > kMovingShare * the joint's largest: a moving row, whose error docs/contract.md counts apart.
constexpr double kMovingShare = 0.02;

// Velocities.
/// fall of ln(mean square) of a joint's torque > kVelocityGain: its velocity is derived from the position;
/// 2 % of the error.
constexpr double kVelocityGain = 0.04;

// Verdicts on joints.
/// error <= kFarAboveFloor * floor: at its floor. Beyond twice, more than three quarters of the squared
/// residual is no noise; floors from repeats include some variation from period to period.
constexpr double kFarAboveFloor = 2.0;
/// error <= kBelowAnySensor, a share of the torque: at its floor; 1 % is better than torque sensors.
constexpr double kBelowAnySensor = 0.01;
/// largest torque of each joint < kNoTorque [N m], [N]: no torque was recorded; no sensor shows as little,
/// and from 1e-16 on tolerances for rounding would count.
constexpr double kNoTorque = 1e-12;
/// distance between samples > kAdjacent [s]: a gap, across which repeats are not compared.
constexpr double kAdjacent = 0.05;
/// share of a recording's samples in gaps or beside them < kFewInGaps: not worth a line.
constexpr double kFewInGaps = 1e-3;
/// time compared with the period before < kCompared periods: no floor from repeats.
constexpr double kCompared = 0.25;
/// part of a base parameter outside the span of the data's > kOutsideSpan of it: it is not determined.
constexpr double kOutsideSpan = 1e-5;

// Standard deviations.
/// blocks of a recording <= kMaxBlocks and >= kFewestBlocks, phases of a period <= kMostPhases: enough for
/// a jackknife, and long beside the correlation of the residuals.
constexpr std::size_t kMaxBlocks = 16, kFewestBlocks = 4;
constexpr double kMostPhases = 8.0;
/// blocks of all recordings together <= kMostBlocks, one at least of each: 10 recordings keep 16 each,
/// 16 recordings eight, 100 one.
constexpr int kMostBlocks = 160;
/// duration of a block >= kFirstBlock [s]; doubled whenever there are too many.
constexpr double kFirstBlock = 1.0;
/// time at the beginning in which a period is sought <= kPeriodSeconds [s].
constexpr double kPeriodSeconds = 125.0;

// Rests.
/// |dq| < kStillTurning [rad/s] or kStillSliding [m/s] for >= kFewestRows rows: a pose; fewer are a reversal.
constexpr double kStillTurning = 5e-3, kStillSliding = 1e-3;
constexpr long kFewestRows = 5;
/// blocks of poses <= kRestBlocks: the clusters of the standard deviations.
constexpr long kRestBlocks = 8;
/// singular value <= kRank * the largest: poses that hardly differ tell nothing.
constexpr double kRank = 1e-6;
/// share of the poses within the printed band = kBand.
constexpr double kBand = 0.95;

// Gains of drives from a known mass.
/// half the 95 % interval < kIdentifiable * |gain|, else the gain is not identifiable.
constexpr double kIdentifiable = 0.25;
/// t value of some joint >= kHeavier, else the recordings do not show the mass.
constexpr double kHeavier = 4.0;
/// clusters >= kFewestClusters, else the same.
constexpr int kFewestClusters = 3;
/// t^2 <= kSurelySigned counts in the vote on the sign: one joint does not outvote all others.
constexpr double kSurelySigned = 1e4;
/// share of a joint's torque by the mass < kUnloaded: the mass does not act on it.
constexpr double kUnloaded = 1e-6;
/// weight on a joint > kNoWeight [N m/kg]: it feels weight.
constexpr double kNoWeight = 1e-9;
/// recordings <= kMostDivisions: all divisions into loaded and free ones are tried.
constexpr std::size_t kMostDivisions = 8;
/// share of a gain's column outside the span of the others < kUntied: rounding, and the gain is not tied
/// to the mass.
constexpr double kUntied = 1e-6;

// Words.
constexpr double kOutside = 0.05;          ///< probability outside of a printed interval
constexpr double kNormal95 = 1.96;         ///< half width of a normal 95 % interval, in standard deviations
constexpr double kLargestRatio = 1000.0;   ///< larger ratios of error to floor are printed as "over 1000"
constexpr double kBandSteps = 1e4;         ///< steps per N m or N that a printed band is rounded to
constexpr double kSolving = 0.4;           ///< share of the work done after reading
constexpr double kValidating = 0.6;        ///< share of the work done after solving

// Memory.
constexpr long kPeriodRows = 8192;         ///< largest number of rows in which a period is sought; more are thinned
constexpr int kPieceRows = 2048;           ///< rows that are read at once
constexpr int kRestPiece = 4096;           ///< rows that are read at once in a search for poses at rest
constexpr double kMostBytes = 256.0 * 1024.0 * 1024.0;  ///< memory of one recording's factors
constexpr std::size_t kGroupsAtOnce = 16;  ///< groups of joints whose factors are in memory together
constexpr long kLookedAt = 20000;          ///< rows of a recording from which units and noise of velocities are judged
constexpr int kSeriesSamples = 15000;      ///< samples of the series for plots, of all recordings together
constexpr int kFewestSamples = 100;        ///< samples of the series for plots that each recording keeps

// Arithmetic.
constexpr double kDependentColumn = 1e-9;  ///< smaller pivots: the column is a combination of others up to rounding
constexpr double kBelowNyquist = 0.45;     ///< share of the sample rate below which positions of instruments are filtered
constexpr double kEndOfTime = 0.999999;    ///< largest time, as a share of a recording, that lies inside its last segment
constexpr int kSpeeds = 30;                ///< speeds of a friction curve in either direction
constexpr int kRun = 60;                   ///< steps that friction with a memory slides before its force is read
constexpr double kRunSeconds = 2.0;        ///< [s] duration of those steps
constexpr int kStates = 200;               ///< random states at which columns of drive gains are compared
constexpr int kIterations = 60;            ///< largest number of Levenberg-Marquardt steps of the drive gains
constexpr double kConverged = 1e-12;       ///< relative fall of the cost at which that search ends
constexpr double kFirstDamping = 1e-6;     ///< its damping at first
constexpr double kLeastDamping = 1e-14;    ///< its smallest damping
constexpr double kMostDamping = 1e6;       ///< its largest damping: no step succeeds
constexpr double kDampingUp = 10.0;        ///< factor of the damping after a step that fails; its inverse after a success
constexpr double kLeastNoise = 1e-9;       ///< smallest noise, as a share of a joint's currents: exact data divide by no zero
constexpr double kNoScale = 1e-9;          ///< gains below this share of the largest one count as zero
// A solid ball stands in for moments of inertia that poses at rest cannot determine.
constexpr double kBallMass = 1.0;          ///< [kg] its mass
constexpr double kBallRadius = 0.1;        ///< [m] its radius
constexpr double kSolidBall = 0.4;         ///< its moment of inertia over mass and squared radius

}  // namespace veridyn::identifying
