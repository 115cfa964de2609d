#pragma once

/// All numbers that can change the findings of `check` on a recording and a robot, each with its
/// inequality, and with its reason where one is known.
namespace veridyn::checking {

/// rows > kMostRows: the rest is not read; 25 s at 200 Hz, and more rows add nothing new.
constexpr int kMostRows = 5000;
/// rows < kFewestRows: no comparison with the robot; 1.5 s at 200 Hz determine no arm.
constexpr int kFewestRows = 300;
/// condition number < kWorstCondition, columns scaled, else no comparison; whole recordings of a PSM
/// have 4600.
constexpr double kWorstCondition = 2e4;
/// The misfit is the sum over the joints of ln(unexplained share of a joint's squared torque), so that
/// a joint that fits badly anyway does not hide another. Its fall > kBetter: a question is answered by yes;
/// as if one joint's share fell to 0.4 of its value.
constexpr double kBetter = 0.9;
/// Fall of the misfit > kGainsBetter: efforts are currents; drive gains differ little from joint to
/// joint, and so do their fits.
constexpr double kGainsBetter = 0.3;
/// what is left <= kNearNoise * the torque's white noise, or the rounding of its digits: no hypothesis is tested, and
/// what led there mends it. Friction near rest leaves a few times the noise on perfect recordings.
constexpr double kNearNoise = 3.0;
/// error left of a joint <= kExact, or kNearNoise times its noise: it is explained. Friction near rest leaves up to 1 % of a joint's torque on perfect recordings.
constexpr double kExact = 1.5e-2;
/// relative error < kSmallestShare: counts as this; less is noise.
constexpr double kSmallestShare = 1e-5;
/// power lost to friction / (rms torque * rms speed) > kFrictionShare: it has a sign.
constexpr double kFrictionShare = 0.03;
/// the same > kFrictionAboveRest * sqrt(unexplained share): what is not explained may do work of its own.
constexpr double kFrictionAboveRest = 0.3;
/// relative rise of the rms misfit without friction > kFrictionSignificance; in the first seconds of a
/// motion other parameters may absorb it. Recordings of a PSM have 0.27 to 2.3.
constexpr double kFrictionSignificance = 0.25;
/// A joint whose friction gives energy adds kGivesEnergy > kBetter to the misfit.
constexpr double kGivesEnergy = 1.5;
/// unexplained share with the file's values < kTelling * that without: their ratio to the torques is used.
constexpr double kTelling = 0.5;
/// |ln(ratio)| > ln(kTorqueFactor): the misfit grows by one for every further such factor, up to kMostOff, which is
/// also what a ratio of the other sign adds.
constexpr double kTorqueFactor = 2.0, kMostOff = 3.0;
/// position < lower - kBeyondLimits * range, or beyond the other end: outside of the joint's limits.
constexpr double kBeyondLimits = 0.05;
/// questions answered together <= kMostTogether.
constexpr int kMostTogether = 4;
/// polish of a direction: steps halve until < kFinest [rad].
constexpr double kFinest = 4e-3;

/// Counts of one turn of usual encoders.
inline constexpr int kCounts[] = {512, 1000, 1024, 2000, 2048, 4000, 4096, 8192, 10000, 16384, 20000, 32768, 65536, 131072, 262144, 524288, 1048576};
/// Units of torque that differ from N m by more than the values of a file may, as "Torques are in mNm", "... are percent of the largest effort".
inline constexpr const char* kTorqueUnits[][2] = {{"mNm", "in"}, {"Ncm", "in"}, {"kNm", "in"}, {"kgcm", "in"}, {"ozin", "in"},
                                                  {"%", "percent"}, {"permille", "thousandths"}, {"share", "shares"}};
/// Angles of all joints span >= kLeastTravel and <= kMostTravel [rad] where counts are turned into them.
constexpr double kLeastTravel = 0.05, kMostTravel = 13.0;
/// tilt = kTilt [rad]: directions of gravity beside that of the file, the axes, edges and corners; polished afterwards.
constexpr double kTilt = 0.35;
/// Gears with kLeastRatio <= ratio < kMostRatio are tried in relative steps of kRatioStep, where positions leave the limits; a ratio
/// within kWholeRatio of a whole number is rounded to it.
constexpr double kLeastRatio = 5.0, kMostRatio = 320.0, kRatioStep = 0.04, kWholeRatio = 3e-3;
/// Another zero of a joint = kZeros [rad], quarter turns, polished from steps of kZeroStep on; near the file's own zero
/// a diagnosis measures it.
inline constexpr double kZeros[] = {-1.5707963267948966, 1.5707963267948966, 3.141592653589793};
constexpr double kZeroStep = 0.1;
/// |component of a direction| < kTiny: rounding.
constexpr double kTiny = 1e-9;
/// kRidge is added to normal equations with a diagonal of ones: columns that others replace get no share.
constexpr double kRidge = 1e-12;
/// folds of contiguous blocks = kFolds; each is predicted from the others.
constexpr int kFolds = 4;
/// [Hz] grid = kGrid, on which recordings are compared where it has kRowsAWave rows a wave of the cut-off.
constexpr double kGrid = 50.0, kRowsAWave = 10.0;
/// Square of the second difference of white noise = kSecondDifference * its variance.
constexpr double kSecondDifference = 6.0;
/// share of a spring's torque that gravity cannot take over < kSpringApart: a spring and a load cannot be separated.
/// and the joint moves over a share < kWeakly of its range, so that other angles are to be expected.
constexpr double kSpringApart = 0.03, kWeakly = 0.25;
/// error left < kLess * that without: the fit counts.
constexpr double kLess = 0.98;
/// error left with transformations < kMostOfIt * that without: a diagnosis continues with them although the model lacks something else.
constexpr double kMostOfIt = 0.1;
/// error left > kOutstanding * that of another recording of the command: it may have a mistake of its own.
constexpr double kOutstanding = 3.0;
/// error left > kUnexplained with any transformation: the torques do not belong to this arm's motion.
constexpr double kUnexplained = 0.6;
/// error left of one joint > kNothing while other joints are explained: its torque does not follow from the motion.
constexpr double kNothing = 0.95;
/// error left with a fitted direction of gravity <= kFittedNear, or kNearNoise times the noise: explained. Perfect recordings leave
/// 0.6 %; a force on the tip of a planar arm leaves 1.3 %.
constexpr double kFittedNear = 8e-3;
/// rows >= kRowsOfAnArm (6 s at 200 Hz): a large error is not due to too few rows.
constexpr int kRowsOfAnArm = 1200;
/// error left of a joint < kSure: a contradiction to friction or to the values of the file there is a wrong sign of its torque.
constexpr double kSure = 0.2;
/// smallest size of a torque < kTouches * its rms: a size without its sign passes zero where the torque changes sign; a torque that
/// gravity holds on one side does not.
constexpr double kTouches = 0.01;
/// sets of answers that are followed <= kBeam.
constexpr int kBeam = 3;
/// error left with an answer < kFitted * error left without it: required of answers that fit numbers or replace the arm, as long as the arm does not fit, and of those that are not sure.
constexpr double kFitted = 0.5;
/// Cost of a position's sign - cost of a torque's = kOfPosition: an arm that is its own mirror image fits both alike.
constexpr double kOfPosition = 0.3;
/// Cost of a question with a number of its own - cost of one without = kOfNumber.
constexpr double kOfNumber = 0.6;
/// error left of a joint > kBadly: its columns may belong to another joint, or its zero be another; missing effects leave less.
constexpr double kBadly = 0.04;
/// relative error of some joint > kAskedAbove: identified recordings are checked.
constexpr double kAskedAbove = 0.08;
/// common factor of torques > 1 / kBehindGear: in front of gears; values of files are less far off.
constexpr double kBehindGear = 0.2;
/// factor of one torque alone > kOwnFactor, or below its inverse: asked; less is left to a diagnosis.
constexpr double kOwnFactor = 1.2;
/// |delay of torques| = kDelays [s], and kDrift times it at the end where another clock runs, polished afterwards: half a wave of
/// usual motions to either side is found.
inline constexpr double kDelays[] = {0.03, 0.1};
constexpr double kDrift = 3.0;
/// Moments at which something may have changed = kMoments - 1; cost of leaving all rows out = kOfRows, so that of parts
/// that fit alike the longest is kept.
constexpr int kMoments = 16;
constexpr double kOfRows = 3.0;
/// steps of inverse iteration = kPowers, of which each divides the rest by the ratio of two eigenvalues.
constexpr int kPowers = 8;
/// speeds of all joints < kAtRest [rad/s or m/s] for kLongRest [s]: the arm rests, and its brakes may carry it.
constexpr double kAtRest = 0.01, kLongRest = 0.5;
/// |share of a range| < kMostShare [%]: a little beyond its ends.
constexpr double kMostShare = 110.0;
/// bit of a load register = kDirectionBit; both directions occur in one row of kBothDirections and more.
constexpr double kDirectionBit = 1024.0, kBothDirections = 20.0;
/// directions around one = kTiltDirections; gravity = kGravity [m/s^2] where the file has none.
constexpr int kTiltDirections = 8;
constexpr double kGravity = 9.81;
/// cosine between the file's gravity and another > kLeaning: within 45 degrees the base leans.
constexpr double kLeaning = 0.7071;
/// step of time >= kShortestStep [s] where a rate is made of it.
constexpr double kShortestStep = 1e-6;

}  // namespace veridyn::checking
