#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "veridyn/effects/cause.hpp"
#include "veridyn/excitation/fourier_trajectory.hpp"
#include "veridyn/excitation/prediction.hpp"
#include "veridyn/excitation/workspace_limits.hpp"
#include "veridyn/model/model.hpp"
#include "veridyn/regressor/joint_friction.hpp"

namespace veridyn {

/// What a good motion is.
enum class ExcitationCriterion {
  /// Smallest condition number of the base regressor (thesis 5.27).
  kCondition,
  /// Largest ln det of its Gram matrix, rows divided by their noise (ExcitationOptions::noise): the
  /// smallest volume of the confidence ellipsoid, and so the smallest geometric mean of the expected
  /// standard deviations along its axes. Amplitude counts; a condition number knows none.
  kDOptimal,
  /// Smallest mean of the base parameters' predicted standard deviations, each relative to the
  /// parameter's value; one that is nearly nothing counts as one that makes 0.1 % of the torques.
  kAOptimal,
  /// Two named causes told apart best, see RivalCause.
  kDiscriminate,
};

/// "condition", "d-optimal", "a-optimal", "discriminate".
const char* name_of(ExcitationCriterion criterion);

/// Who searches.
enum class ExcitationSolver {
  kInteriorPoint,  ///< primal-dual interior point with exact gradients and Jacobian
  kIpopt,          ///< Ipopt, where the library was built with it
  kNlopt,          ///< sequential quadratic programming of NLopt, where the library was built with it
  kRandom,         ///< random motions within the joints' limits; the best of them
};

/// "interior-point", "ipopt", "nlopt", "random".
const char* name_of(ExcitationSolver solver);

/// False for Ipopt and NLopt where the library was built without them.
bool is_built_in(ExcitationSolver solver);

/// How columns of the base regressor are scaled before the condition number.
enum class ColumnScaling {
  kNorm,  ///< to norm one (thesis 5.26)
  kNone,  ///< as they are
  /// Combined first into a basis that is orthogonal at random states within the limits, then to
  /// norm one: without what is near to dependent in the arm's geometry, which no motion can change.
  kOrthogonal,
};

/// "norm", "none", "orthogonal".
const char* name_of(ColumnScaling scaling);

/// A cause of torque: an effect of CONTRACT.md and its joint (name or number from 1) or frame.
/// `payload` and `inertia` (of a body that turns with the frame) stand on a frame; `gravity_tilt`
/// needs no place; `torque_gain`, `payload` and `gravity_tilt` follow from the arm's own values.
using RivalCause = CauseText;

struct ExcitationOptions {
  double frequency = 0.13;  ///< [Hz] of the fundamental wave
  int harmonics = 5;        ///< at least 2: one alone cannot start at rest
  double duration = 30.0;   ///< [s] wanted; rounded to whole periods, at least two
  double rate = 200.0;      ///< [Hz] of the samples
  /// Of every joint (for kDiscriminate: of the rivals' joints, where they have some) after the last
  /// period, for friction: there and back at a slow, constant speed, within all limits. The
  /// criterion does not know of them.
  int slow_passes = 0;
  ExcitationCriterion criterion = ExcitationCriterion::kDOptimal;
  std::optional<std::pair<RivalCause, RivalCause>> between{};  ///< for kDiscriminate
  ColumnScaling scaling = ColumnScaling::kNorm;                ///< for kCondition
  /// Above zero: the criterion is about the essential parameters only, see EssentialParameters;
  /// below 1. Not for kDiscriminate, which asks about rivals.
  double essential = 0.0;
  ExcitationSolver solver = ExcitationSolver::kInteriorPoint;
  int starts = 2;  ///< independent searches, of which the best wins
  /// Iterations of each descent, motions of kRandom in each search; the result depends on this and not on the clock.
  int iterations = 400;
  /// Of the limits of joints and torques that may be used, above 0 and at most 1. Nothing: what a
  /// safety supervisor needs (SafetySupervisor, MotionCheck): 98 % of speeds, 95 % of torques, of ranges
  /// all but 0.25 % at each end from where the joint still stops before the limit, accelerations
  /// whole.
  std::optional<double> limit_share{};
  double braking = 30.0;  ///< [1/s] it stops within dq / braking, as SafetyLimits::braking has it
  /// Friction beside that of the robot file, as an identification of the recording would have it.
  JointFriction friction = JointFriction::kAuto;
  WorkspaceLimits workspace{};
  /// The arm with values of its bodies (and effects, where it has them): its efforts limit the
  /// torques, and rivals are built from it. Nothing: the arm itself, where it has values.
  std::optional<Model> powered{};
  /// Of the torques, for kDOptimal, kAOptimal and the prediction; nothing: usual_noise() of the arm
  /// with values.
  std::optional<TorqueNoise> noise{};
  /// The arm with values for the prediction and kAOptimal only; nothing: `powered`, or the arm
  /// itself.
  std::optional<Model> valued{};
  /// Motions that are recorded already; their information counts. Samples of their own rate.
  std::vector<MotionSamples> given{};
  unsigned seed = 1;
  int threads = 0;  ///< Number of threads; 0: one per core; the result does not depend on it
  /// Called with (what is being done, share done), by one thread at a time.
  std::function<void(const std::string&, double)> progress{};
  /// Asked now and then by all searches; once true, the best motion so far is the result.
  std::function<bool()> stop{};
};

enum class ExcitationStatus {
  kDone,
  kRankDeficient,  ///< no motion was found that excites all base parameters; the best one is given
  kLimitsNotMet,   ///< no motion was found within the limits; `margins` say by how much not
};

/// How close a motion comes to one limit; also between samples.
struct LimitMargin {
  std::string name;  ///< "speed of yaw", "torque of pitch", "x of tool", ...
  std::string unit;
  double lowest = 0.0;  ///< the motion's range
  double highest = 0.0;
  double lower = 0.0;  ///< the limit
  double upper = 0.0;
  double margin = 0.0;  ///< to the nearer bound, negative where it is crossed
};

/// What a motion uses of the limits of one joint, as shares; NaN where there is no limit, or where
/// torques are not known.
struct UsedLimits {
  double range = 0.0;     ///< largest minus smallest position
  double velocity = 0.0;  ///< largest speed
  double effort = 0.0;    ///< largest torque
  /// Limits that the motion comes closest to and that hold this joint; empty: none does.
  std::vector<std::string> held_by{};
};

/// A joint that uses less than this of its range and of its speed says little of its inertia and
/// nothing of its friction.
constexpr double kLittleUse = 0.4;

/// What the motion says about two rivals; roots of mean squares of torque in units of the
/// rows' weights, per unit of the rival's parameter (of a payload: 1 kg within 0.1 m). Zero for a
/// rival that does nothing which the other one cannot do as well, whatever the motion.
struct Discrimination {
  std::string first, second;
  double first_left = 0.0;   ///< Share of the first cause's torque that remains after everything else
  double second_left = 0.0;  ///< The same of the second cause
  /// The same as a share of what the rest of the model leaves of it, 0 to 1.
  double first_share = 0.0, second_share = 0.0;
  bool bodies_known = false;  ///< the rivals can only be told apart with known bodies
};

/// Base parameters that motions tell from each other. A column (of norm one, at random states
/// within the limits) that adds less than `share` to those chosen before it is regrouped with them:
/// its parameter acts as a part of theirs and is not asked for.
struct EssentialParameters {
  double share = 0.0;
  int count = 0;
  double condition_number = 0.0;        ///< Condition number of their columns scaled to norm one
  double plain_condition_number = 0.0;  ///< columns as they are
  double range_condition_number = 0.0;  ///< columns divided by their range
  /// Names, and what their columns would add; the largest first.
  std::vector<std::pair<std::string, double>> left_out{};
};

/// An excitation trajectory and how good it is.
struct Excitation {
  ExcitationStatus status = ExcitationStatus::kDone;
  std::string robot;
  ExcitationCriterion criterion = ExcitationCriterion::kCondition;
  ExcitationSolver solver = ExcitationSolver::kInteriorPoint;
  FourierTrajectory trajectory;
  MotionSamples motion{};  ///< all of it, from rest to rest, at ExcitationOptions::rate
  int periods = 0;
  double slow_seconds = 0.0;  ///< how long the slow passes last that follow
  int base_parameters = 0;
  /// The standard parameters that lead them. A base is a choice among columns that say the same
  /// together; where the condition number of scaled columns is the criterion it is the choice which
  /// is best conditioned along this motion, otherwise that at random states.
  std::vector<std::string> base{};
  double condition_number = 0.0;        ///< Condition number of the base regressor, columns scaled to norm one
  double plain_condition_number = 0.0;  ///< columns as they are
  double range_condition_number = 0.0;  ///< columns divided by their largest minus smallest entry
  double orthogonal_condition_number = 0.0;  ///< see ColumnScaling::kOrthogonal
  /// As condition_number, of this motion and the given recordings together; equal without any.
  double condition_number_with_given = 0.0;
  /// Of its Gram matrix per instant, columns scaled by their size at random states.
  double log_determinant = 0.0;
  double start_condition_number = 0.0;  ///< Condition number of the first random motion, in the same columns
  /// Of the share asked for; of 0.01 where none was, if that leaves any out.
  std::optional<EssentialParameters> essential{};
  std::optional<Discrimination> discrimination{};
  /// The base parameters that the motion tells least from each other: names and parts (of norm one)
  /// of the weakest direction, columns scaled to norm one; the largest parts first.
  std::vector<std::pair<std::string, double>> weakest{};
  std::optional<Prediction> prediction{};  ///< Given where the arm's values are known
  long evaluations = 0;
  bool interrupted = false;
  bool converged = false;  ///< the solver said so for the motion that won
  double seconds = 0.0;
  std::vector<LimitMargin> margins{};
  std::vector<UsedLimits> used{};     ///< (n)
  double limit_share = 0.0;           ///< ExcitationOptions::limit_share; 0: what a supervisor needs
  std::string friction_remark{};      ///< veridyn::friction_remark()
  MotionBounds bounds{};              ///< Bounds of the periods
  MotionBounds limits{};              ///< Limits of the arm, in the same order
  std::vector<std::string> joints{};  ///< names of the coordinates
  std::vector<std::string> units{};   ///< "rad" or "m"

  /// Status, quality and margins to the limits, as text.
  std::string report() const;

  /// A sentence on every joint of little use (kLittleUse), with the limit that forbids more.
  std::vector<std::string> warnings() const;
};

/// Searches a Fourier trajectory that starts and stops at rest, repeats its period, keeps within
/// all limits (between samples as well) and excites what the criterion asks for.
///
/// Multi-start: each search makes short descents from some random motions (kInteriorPoint only) and
/// follows the best of them down a smooth stand-in of the criterion with exact gradients; for the
/// condition number of scaled columns the base columns are then chosen along the motion, and the
/// descent goes on. The criterion itself, on the samples of the motion, says which search won. The
/// same options give the same motion, on any number of threads.
/// @throws InvalidInput  an option is out of range, or names what the arm does not have.
Excitation optimise_excitation(const Model& arm, const ExcitationOptions& options = {});

}  // namespace veridyn
