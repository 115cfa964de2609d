#pragma once

/// All numbers that can change the findings of `check` on a recording and a robot. Each comment gives the
/// condition, then its consequence, and the reason where one is known.
namespace veridyn::checking {

/// rows > kMostRows: the rest is not read; 25 s at 200 Hz are sufficient.
constexpr int kMostRows = 5000;
/// rows < kFewestRows: no comparison with the robot; 1.5 s at 200 Hz do not determine an arm.
constexpr int kFewestRows = 300;
/// condition number of the scaled columns < kWorstCondition, else no comparison; whole recordings of a PSM
/// have 4600.
constexpr double kWorstCondition = 2e4;
/// The misfit is the sum over the joints of ln(unexplained share of a joint's squared torque), so that a
/// joint that fits badly in any case does not hide another one. Decrease of the misfit > kMisfitDecrease: a
/// hypothesis is accepted; this corresponds to one joint's share falling to 0.4 of its value. The same for the misfit of a fit
/// to all rows, none of them held out.
constexpr double kMisfitDecrease = 0.9;
/// Decrease of the misfit > kGainsBetter: efforts are taken as currents. Drive gains differ little between
/// joints, so that the two fits differ little.
constexpr double kGainsBetter = 0.3;
/// remaining error <= kNearNoise * the torque's white noise, or the rounding of its digits: no further
/// hypothesis is tested, and those accepted so far are applied. Friction near rest leaves a few times the
/// noise on perfect recordings.
constexpr double kNearNoise = 3.0;
/// remaining error of a joint <= kExact, or kNearNoise times its noise: it is explained. Friction near rest
/// leaves up to 1 % of a joint's torque on perfect recordings.
constexpr double kExact = 1.5e-2;
/// relative error < kSmallestShare: replaced by this value; smaller errors are noise.
constexpr double kSmallestShare = 1e-5;
/// power lost to friction / (rms torque * rms speed) > kFrictionShare: the sign of the friction is significant.
constexpr double kFrictionShare = 0.03;
/// power lost to friction / (rms torque * rms speed) > kFrictionAboveRest * sqrt(unexplained share), since that
/// part may do work.
constexpr double kFrictionAboveRest = 0.3;
/// relative increase of the rms misfit without friction > kFrictionSignificance: in the first seconds of a
/// motion other parameters may absorb friction. Recordings of a PSM have 0.27 to 2.3.
constexpr double kFrictionSignificance = 0.25;
/// A joint with negative friction adds kNegativeFrictionCost > kMisfitDecrease to the misfit.
constexpr double kNegativeFrictionCost = 1.5;
/// unexplained share with the file's values < kFileTorquesUsable * that with fitted ones: the ratio of their torques to
/// the recorded ones is used.
constexpr double kFileTorquesUsable = 0.5;
/// |ln(ratio)| > ln(kTorqueFactor): the misfit increases by one for each further factor of this size, up to
/// kMostOff, which a ratio of the wrong sign adds as well.
constexpr double kTorqueFactor = 2.0, kMostOff = 3.0;
/// position < lower limit - kBeyondLimits * range, or as far above the upper one: outside of the joint's
/// limits.
constexpr double kBeyondLimits = 0.05;
/// number of mistakes that are assumed at the same time <= kMostTogether.
constexpr int kMostTogether = 4;
/// refinement of a direction of gravity: steps are halved until < kFinest [rad].
constexpr double kFinest = 4e-3;

/// Counts of one turn of usual encoders.
inline constexpr int kCounts[] = {512, 1000, 1024, 2000, 2048, 4000, 4096, 8192, 10000, 16384, 20000, 32768, 65536, 131072, 262144, 524288, 1048576};
/// Units of torque that differ from N m by more than the values of a file may, as "Torques are in mNm", "... are percent of the largest effort".
inline constexpr const char* kTorqueUnits[][2] = {{"mNm", "in"}, {"Ncm", "in"}, {"kNm", "in"}, {"kgcm", "in"}, {"ozin", "in"},
                                                  {"%", "percent"}, {"permille", "thousandths"}, {"share", "shares"}};
/// Angles of all joints span >= kLeastTravel and <= kMostTravel [rad] where counts are turned into them.
constexpr double kLeastTravel = 0.05, kMostTravel = 13.0;
/// tilt = kTilt [rad]: directions of gravity next to that of the file, along axes, edges and corners; refined
/// afterwards.
constexpr double kTilt = 0.35;
/// Gear ratios kLeastRatio <= ratio < kMostRatio are tried in relative steps of kRatioStep if positions leave
/// the limits; a ratio within kWholeRatio of an integer is rounded to it.
constexpr double kLeastRatio = 5.0, kMostRatio = 320.0, kRatioStep = 0.04, kWholeRatio = 3e-3;
/// Zeros of a joint = kZeros [rad], quarter turns, refined from steps of kZeroStep; a diagnosis measures
/// smaller offsets.
inline constexpr double kZeros[] = {-1.5707963267948966, 1.5707963267948966, 3.141592653589793};
constexpr double kZeroStep = 0.1;
/// |component of a direction| < kTiny: rounding.
constexpr double kTiny = 1e-9;
/// kRidge is added to normal equations with a diagonal of ones, so that dependent columns can be solved for.
constexpr double kRidge = 1e-12;
/// number of folds of contiguous blocks = kFolds; each fold is predicted from the others.
constexpr int kFolds = 4;
/// [Hz] rate at which recordings are compared = the larger one of kGrid and kRowsAWave rows per period of the cut-off.
constexpr double kGrid = 50.0, kRowsAWave = 10.0;
/// Square of the second difference of white noise = kSecondDifference * its variance.
constexpr double kSecondDifference = 6.0;
/// share of a spring's torque that gravity cannot represent < kSpringApart: spring and load cannot be
/// separated. It is reported if the joint moves over a share < kWeakly of its range, where a larger motion is
/// possible.
constexpr double kSpringApart = 0.03, kWeakly = 0.25;
/// remaining error < kFitCounts * the error without the hypothesis: the report gives this improvement as the
/// reason.
constexpr double kFitCounts = 0.98;
/// torque > kBeyondEffort * the joint's largest effort: the torque is impossible in this unit.
constexpr double kBeyondEffort = 3.0;
/// remaining error with transformations < kClearImprovement * the error without them: a diagnosis applies them even
/// though the model lacks something else.
constexpr double kClearImprovement = 0.1;
/// remaining error > kUnexplained with any transformation: the torques do not belong to this arm's motion.
constexpr double kUnexplained = 0.6;
/// remaining error of one joint > kUnexplainedJoint while other joints are explained: its torque does not follow from
/// the motion.
constexpr double kUnexplainedJoint = 0.95;
/// remaining error with a fitted direction of gravity <= kFittedNear, or kNearNoise times the noise:
/// explained. Perfect recordings leave 0.6 %; a force on the tip of a planar arm leaves 1.3 %.
constexpr double kFittedNear = 8e-3;
/// rows >= kRowsOfAnArm (6 s at 200 Hz): a large error does not come from too few rows.
constexpr int kRowsOfAnArm = 1200;
/// remaining error of a joint < kSignCertain: negative friction, or torques opposite to those of the file's values,
/// mean that its torque has the wrong sign.
constexpr double kSignCertain = 0.2;
/// smallest absolute torque < kReachesZero * its rms: the recorded torque reaches zero without changing its sign,
/// so that its sign was lost; a torque that gravity keeps on one side does not reach zero.
constexpr double kReachesZero = 0.01;
/// number of hypotheses that are extended in each round <= kBeam.
constexpr int kBeam = 3;
/// remaining error with a hypothesis <= kFitted * that without it: required of uncertain hypotheses, and of
/// those with fitted numbers or another arm, which reduce the error of any incomplete model a little.
constexpr double kFitted = 0.5;
/// Cost of a wrong sign of a position minus that of a torque = kPositionSignCost: an arm that is its own mirror
/// image fits both equally well.
constexpr double kPositionSignCost = 0.3;
/// Additional cost of a hypothesis with a fitted number = kFittedNumberCost.
constexpr double kFittedNumberCost = 0.6;
/// remaining error of a joint > kPoorFit: its columns may belong to another joint, or its zero may differ;
/// missing effects cause less.
constexpr double kPoorFit = 0.04;
/// relative error of some joint > kCheckAboveError: the recordings of an identification are checked.
constexpr double kCheckAboveError = 0.08;
/// common factor of all torques > 1 / kBehindGear: measured in front of gears; the values of files are closer
/// to the truth.
constexpr double kBehindGear = 0.2;
/// factor of a single torque > kOwnFactor, or below its inverse: tested here; a diagnosis estimates smaller
/// ones.
constexpr double kOwnFactor = 1.2;
/// Tested delays of torques: +-kDelays [s], also with a drift of kDrift times the delay over the recording,
/// as between two clocks; refined afterwards. Delays of up to half a period of usual motions are found.
inline constexpr double kDelays[] = {0.03, 0.1};
constexpr double kDrift = 3.0;
/// Tested time constants of a low-pass of all torques = kFilters [s], 3, 1 and 0.3 Hz, refined afterwards from relative steps
/// of kFactorStep.
inline constexpr double kFilters[] = {0.053, 0.16, 0.53};
constexpr double kFactorStep = 0.3;
/// A change within a recording is tested at kMoments - 1 moments; cost of excluding rows = kExcludedRowsCost,
/// so that the longest part is kept among those that fit equally well.
constexpr int kMoments = 16;
constexpr double kExcludedRowsCost = 3.0;
/// number of inverse iterations = kPowers; each divides the error by the ratio of two eigenvalues.
constexpr int kPowers = 8;
/// speeds of all joints < kAtRest [rad/s or m/s] for kLongRest [s]: the arm is at rest and may be held by its
/// brakes.
constexpr double kAtRest = 0.01, kLongRest = 0.5;
/// |share of a range| < kMostShare [%]: positions may lie slightly beyond the ends.
constexpr double kMostShare = 110.0;
/// Torques of servos may be load registers, in which the bit kDirectionBit is the direction; both directions
/// must occur, each in at least one of kBothDirections rows.
constexpr double kDirectionBit = 1024.0, kBothDirections = 20.0;
/// number of directions tested around one of gravity = kTiltDirections; gravity = kGravity [m/s^2] if the file
/// has none.
constexpr int kTiltDirections = 8;
constexpr double kGravity = 9.81;
/// cosine between the file's gravity and another direction > kLeaning: within 45 degrees the finding is a
/// tilted base.
constexpr double kLeaning = 0.7071;
/// time step >= kShortestStep [s] where a rate is computed from it.
constexpr double kShortestStep = 1e-6;

}  // namespace veridyn::checking
