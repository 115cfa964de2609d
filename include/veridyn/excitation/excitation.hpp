// excitation/: motions that identify an arm well, within its limits.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "veridyn/effects/cause.hpp"
#include "veridyn/excitation/fourier_trajectory.hpp"
#include "veridyn/excitation/prediction.hpp"
#include "veridyn/excitation/workspace_limits.hpp"
#include "veridyn/model/model.hpp"
#include "veridyn/identification/joint_friction.hpp"

namespace veridyn {

/// Optimality criterion of a motion.
enum class ExcitationCriterion {
  /// Smallest condition number of the base regressor (thesis 5.27).
  kCondition,
  /// Largest ln det of its Gram matrix, rows divided by their noise (ExcitationOptions::noise): the smallest volume
  /// of the confidence ellipsoid. Unlike a condition number it depends on the amplitude of the motion.
  kDOptimal,
  /// Smallest mean of the base parameters' predicted standard deviations, each relative to the
  /// parameter's value; a parameter near zero is replaced by one that makes 0.1 % of the torques.
  kAOptimal,
  /// Best separation of two causes.
  kDiscriminate,
};

/// "condition", "d-optimal", "a-optimal", "discriminate".
const char* name_of(ExcitationCriterion criterion);

/// Optimisation method.
enum class ExcitationSolver {
  kInteriorPoint,  ///< primal-dual interior point with exact gradients and Jacobian
  kIpopt,          ///< Ipopt, if the library was built with it
  kNlopt,          ///< sequential quadratic programming of NLopt, if the library was built with it
  kRandom,         ///< the best of several random motions within the joints' limits
};

/// "interior-point", "ipopt", "nlopt", "random".
const char* name_of(ExcitationSolver solver);

/// False for Ipopt and NLopt if the library was built without them.
bool is_built_in(ExcitationSolver solver);

/// Scaling of the base regressor's columns before the condition number is computed.
enum class ColumnScaling {
  kNorm,  ///< columns are scaled to norm one (thesis 5.26)
  kNone,  ///< columns are not scaled
  /// Columns are first combined into a basis that is orthogonal at random states within the limits, then scaled
  /// to norm one: this removes dependences of the arm's geometry that no motion can change.
  kOrthogonal,
};

/// "norm", "none", "orthogonal".
const char* name_of(ColumnScaling scaling);

struct ExcitationOptions {
  double frequency = 0.13;  ///< [Hz] frequency of the first harmonic
  int harmonics = 5;        ///< number of harmonics, at least 2: a single one cannot start at rest
  double duration = 30.0;   ///< [s] requested; rounded to whole periods, at least two
  double rate = 200.0;      ///< [Hz] sample rate
  /// Slow passes back and forth of every joint (for kDiscriminate: of the joints of the two causes) after the
  /// last period, for friction: at constant speed and within all limits. The criterion does not include them.
  int slow_passes = 0;
  ExcitationCriterion criterion = ExcitationCriterion::kDOptimal;
  /// The two causes of kDiscriminate: effects, loads, errors of channels. Torque gains, loads and tilts
  /// use the arm's own values.
  std::optional<std::pair<Cause, Cause>> between{};
  ColumnScaling scaling = ColumnScaling::kNorm;                ///< used by kCondition
  /// Threshold EssentialParameters::share, at least 0 and below 1. Above 0, the criterion uses the essential
  /// parameters only; this is not available for kDiscriminate.
  double essential = 0.0;
  ExcitationSolver solver = ExcitationSolver::kInteriorPoint;
  int starts = 2;  ///< independent searches; the best one is returned
  /// Iterations of each descent, motions of kRandom in each search. The search ends by this count, never by time.
  int iterations = 400;
  /// Share of the limits of joints and torques that may be used, above 0 and at most 1. Nullopt: margins of a
  /// safety supervisor (SafetySupervisor, MotionCheck): 98 % of speeds, 95 % of torques, whole accelerations, and
  /// ranges reduced by 0.25 % at each end and by the braking distance.
  std::optional<double> limit_share{};
  /// Share of its designed speed at which the motion is played, above 0 and at most 1: the same path, for a
  /// first run.
  double speed = 1.0;
  /// [1/s] a joint stops within dq / braking: the braking distance, see SafetyLimits::braking
  double braking = 30.0;
  /// Friction in addition to that of the robot file, as a later identification will add it.
  JointFriction friction = JointFriction::kAuto;
  WorkspaceLimits workspace{};
  /// The arm with values of its bodies (and effects, where it has them): its efforts limit the torques, and the
  /// causes of kDiscriminate are built from it. Nullopt: the arm itself, where it has values.
  std::optional<Model> powered{};
  /// Torque noise for kDOptimal, kAOptimal and the prediction; nullopt: usual_noise() of the arm
  /// with values for the design, expected_noise() for the prediction.
  std::optional<TorqueNoise> noise{};
  /// The arm with values for the prediction and kAOptimal only; nullopt: `powered`, or the arm itself.
  std::optional<Model> valued{};
  /// Motions recorded earlier, whose information is added; sampled at their own rate.
  std::vector<MotionSamples> given{};
  unsigned seed = 1;
  int threads = 0;  ///< 0: one per core; the result does not depend on it
  /// Called with (current activity, share done), by one thread at a time.
  std::function<void(const std::string&, double)> progress{};
  /// Polled by all searches; if it returns true, the best motion so far is the result.
  std::function<bool()> stop{};
  /// keep: called with the number of a start and its result as numbers when it is finished, by several
  /// threads. kept: called before a start; returns the result if an interrupted search of the same arm and
  /// options has stored it, so that the start is skipped.
  std::function<void(int, const VectorXd&)> keep{};
  std::function<std::optional<VectorXd>(int)> kept{};
};

enum class ExcitationStatus {
  kDone,
  kRankDeficient,  ///< no motion was found that excites all base parameters; the best one is given
  kLimitsNotMet,   ///< no motion was found within the limits; `margins` has the violations
};

/// Distance of a motion from one limit, between samples as well.
struct LimitMargin {
  std::string name;  ///< "speed of yaw", "torque of pitch", "x of tool", ...
  std::string unit;
  double lowest = 0.0;  ///< the motion's range
  double highest = 0.0;
  double lower = 0.0;  ///< the limit
  double upper = 0.0;
  double margin = 0.0;  ///< distance from the nearer bound, negative if it is exceeded
  LimitKind kind = LimitKind::kPlace;
  std::optional<JointIndex> joint = {};  ///< nullopt: kPlace
};

/// Largest use of the limits of one joint, as shares; NaN if there is no limit, or if torques are unknown.
struct UsedLimits {
  double range = 0.0;     ///< largest minus smallest position
  double velocity = 0.0;  ///< largest speed
  double effort = 0.0;    ///< largest torque
  /// Active limits of the motion that involve this joint; empty: none does.
  std::vector<std::string> held_by{};
};

/// A joint that uses less than this of its range and of its speed hardly identifies its inertia,
/// and its friction not at all.
constexpr double kLittleUse = 0.4;

/// The lowest point of a motion in the world.
struct LowestPoint {
  double z = std::numeric_limits<double>::quiet_NaN();  ///< [m]
  std::string frame{};
};

/// Separation of two causes by the motion: rms torques in units of the rows' noise, per unit of the cause's
/// parameter (for a payload: 1 kg within 0.1 m). Zero for a cause whose torque the other one can reproduce in
/// any motion.
struct Discrimination {
  std::string first, second;
  /// Part of the first cause's torque that remains after regression on all other columns.
  double first_left = 0.0;
  double second_left = 0.0;  ///< part of the second cause's torque that remains in the same way
  /// These parts as shares of those that remain after regression on the rest of the model without the other
  /// cause, 0 to 1.
  double first_share = 0.0, second_share = 0.0;
  bool bodies_known = false;  ///< the causes can be separated only if the bodies are known
};

/// Base parameters that motions can separate. A column (of norm one, at random states within the limits) that
/// adds less than `share` to those chosen before it is regrouped with them: its parameter becomes part of
/// theirs and is not estimated separately.
struct EssentialParameters {
  double share = 0.0;
  int count = 0;
  double condition_number = 0.0;        ///< condition number of their columns scaled to norm one
  double plain_condition_number = 0.0;  ///< condition number of the unscaled columns
  double range_condition_number = 0.0;  ///< condition number of the columns divided by their range
  /// Regrouped parameters and what their columns would add; the largest first.
  std::vector<std::pair<std::string, double>> non_essential{};
};

/// An excitation trajectory and its quality.
struct Excitation {
  ExcitationStatus status = ExcitationStatus::kDone;
  std::string robot;
  ExcitationCriterion criterion = ExcitationCriterion::kCondition;
  ExcitationSolver solver = ExcitationSolver::kInteriorPoint;
  FourierTrajectory trajectory;
  MotionSamples motion{};  ///< complete motion, from rest to rest, at ExcitationOptions::rate
  int periods = 0;
  double slow_seconds = 0.0;  ///< duration of the slow passes that follow
  int base_parameters = 0;
  /// The leading standard parameters. A base is a choice among columns that span the same space;
  /// where the condition number of scaled columns is the criterion, the base with the smallest one
  /// along this motion is chosen, otherwise the base at random states.
  std::vector<std::string> base{};
  double condition_number = 0.0;        ///< condition number of the base regressor, columns scaled to norm one
  double plain_condition_number = 0.0;  ///< condition number of the unscaled base regressor
  /// Condition number of the columns divided by the difference of their largest and smallest entries.
  double range_condition_number = 0.0;
  double orthogonal_condition_number = 0.0;  ///< see ColumnScaling::kOrthogonal
  /// Like condition_number, of this motion and the given recordings together; equal without any.
  double condition_number_with_given = 0.0;
  /// ln det of the Gram matrix per instant, columns scaled by their size at random states.
  double log_determinant = 0.0;
  /// Condition number of the first random motion, in the same columns.
  double start_condition_number = 0.0;
  /// Essential parameters for ExcitationOptions::essential, or for 0.01 if that is zero and any would be regrouped.
  std::optional<EssentialParameters> essential{};
  std::optional<Discrimination> discrimination{};
  /// The combination of base parameters that the motion identifies worst: names and parts (of norm
  /// one) of the weakest direction, columns scaled to norm one; the largest parts first.
  std::vector<std::pair<std::string, double>> weakest{};
  std::optional<Prediction> prediction{};  ///< nullopt where the arm has no values
  long evaluations = 0;
  bool interrupted = false;
  bool converged = false;  ///< the solver reported convergence for the chosen motion
  double seconds = 0.0;
  std::vector<LimitMargin> margins{};
  std::vector<UsedLimits> used{};     ///< (n)
  double limit_share = 0.0;  ///< ExcitationOptions::limit_share; 0: margins of a safety supervisor
  std::vector<std::string> touching{};  ///< CollisionLimits::touching of the options
  LowestPoint lowest{};
  /// One sentence for each limit that was not checked and each assumption; the report begins with them.
  std::vector<std::string> cautions{};
  double speed = 1.0;  ///< ExcitationOptions::speed
  std::string friction_remark{};      ///< text of veridyn::friction_remark()
  MotionBounds bounds{};              ///< extremes of the motion's periods
  MotionBounds limits{};              ///< limits of the arm, in the same order
  std::vector<std::string> joints{};  ///< names of the coordinates
  std::vector<std::string> units{};   ///< "rad" or "m"

  /// Status, quality and margins to the limits, as text.
  std::string report() const;

  /// A sentence on every joint of little use (kLittleUse), with the limit that prevents more.
  std::vector<std::string> warnings() const;
};

/// Searches for a Fourier trajectory that starts and stops at rest, repeats its period, satisfies all limits
/// (between samples as well) and optimises the criterion.
///
/// For kDOptimal and kAOptimal every joint uses at least kLittleUse of its range, if the other limits allow it.
///
/// Multi-start: each search makes short descents from some random motions (kInteriorPoint only) and
/// continues the best of them on a smooth approximation of the criterion with exact gradients; for
/// the condition number of scaled columns the base columns are then chosen along the motion, and
/// the descent continues. The exact criterion, on the samples of the motion, decides between the
/// searches. The same options give the same motion, on any number of threads.
/// @throws InvalidInput  an option is out of range, or names a part that the arm does not have.
Excitation optimise_excitation(const Model& arm, const ExcitationOptions& options = {});

}  // namespace veridyn
