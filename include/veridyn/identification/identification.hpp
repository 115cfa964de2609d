// identification/: from recordings to a model with standard deviations: base parameters, least squares, validation, fleets.
#pragma once

#include <functional>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "veridyn/identification/base_parameters.hpp"
#include "veridyn/identification/joint_friction.hpp"
#include "veridyn/identification/compressed_recording.hpp"
#include "veridyn/identification/drive_gains.hpp"
#include "veridyn/identification/feasible_least_squares.hpp"

namespace veridyn {

enum class Method {
  kOls,       ///< ordinary least squares on the base parameters
  kWls,       ///< weighted least squares, with one weight for the rows of each joint
  kFeasible,  ///< weighted least squares, in which every body is physically possible
  kIv,     ///< instrumental variables from a simulated motion; not from factors
  kDidim,  ///< least squares along a simulated motion alone; not from factors
};

/// Weighting of the joints' rows by kWls and kFeasible.
enum class JointWeights {
  kRange,     ///< 1 / (max - min) of the joint's torque
  kResidual,  ///< 1 / standard deviation of the joint's residual in the fit with kRange
};

/// Sign constraints of feasible least squares on the effects' parameters.
enum class EffectSigns {
  kPhysical,  ///< friction, inertia and stiffness are nonnegative
  kAny,       ///< unconstrained, as in most published identifications; for comparison
};

struct IdentificationOptions {
  Method method = Method::kFeasible;
  JointWeights weights = JointWeights::kRange;
  PhysicalCondition condition = PhysicalCondition::kPseudoInertia;  ///< for kFeasible
  EffectSigns signs = EffectSigns::kPhysical;                       ///< for kFeasible
  /// Friction that is identified in addition to that of the robot file; see Identification::remarks.
  JointFriction friction = JointFriction::kAuto;
  PreprocessingOptions preprocessing;
  std::optional<PreprocessingOptions> test_preprocessing;  ///< options for test recordings; nullopt: the same
  /// For kFeasible: regularises towards the inertial parameters of this model, by the entropic
  /// divergence; its bodies need values.
  std::optional<Model> prior;
  /// Weight of the prior, as a share of the weighted residual per body.
  double prior_weight = 1e-3;
  /// Known loads in some training recordings: the drive gains are identified first, see find_drive_gains(),
  /// and then the arm from the recordings without a load.
  std::vector<KnownMass> known_masses;
  /// For identify() of recordings: a recorded velocity that is noisier than its position's derivative, or wrong in
  /// scale, is replaced by that derivative if this lowers the error of the joint's torque on the training
  /// recordings by at least 2 %; Identification::preprocessing has the choice. Factors keep the choice made when
  /// they were compressed; Filtering::kSignals, which filters the velocity itself, keeps the recorded velocity.
  bool choose_velocities = true;
  int threads = 0;  ///< recordings are read in parallel; 0: one thread per core
  /// Called with (current activity, share done) between recordings.
  std::function<void(const std::string&, double)> progress;
};

enum class IdentificationStatus {
  kDone,
  /// The recordings leave base parameters of the arm undetermined; see `undetermined`.
  kRankDeficient,
  kNoData,         ///< no usable samples remain
  kNotConverged,  ///< the feasible solver did not reach its duality gap; the best point is returned
  /// The known masses do not determine the drive gains, and the robot file has none.
  kNoDriveGains,
};

struct BaseValue {
  std::string name;
  std::string expression;
  std::string unit;
  double value = 0.0;
  double std = 0.0;  ///< standard deviation by block jackknife, valid for correlated samples
};

/// Errors of the identified model on one recording.
struct RecordingError {
  std::string source;
  PredictionError error;  ///< errors on every row, as recorded
  /// Errors on every row, with repeated rows of a late publisher interpolated; empty if there were none.
  PredictionError repaired;
  /// Errors outside of the intervals of PreprocessingOptions::excluded_intervals; empty if none is in this
  /// recording.
  PredictionError without_excluded;
  FilledRows filled;
  long rows = 0;         ///< rows of the file
  VectorXd noise_floor;  ///< relative noise floor (n); empty if nothing repeats
  double period = 0.0;   ///< [s] period of the motion; 0: no repetition
  PredictionSeries series;
  std::string learned_from;  ///< for a test recording: a training recording that contains its rows
};

/// Durbin-Wu-Hausman test of one joint, of the hypothesis that the noise of its regressor is uncorrelated with that
/// of its torque; if it is rejected, least squares is biased. F statistic of an augmented regression, for the
/// number of independent samples from the jackknife (Janot, Vandanjon and Gautier, IEEE Trans. CST 22(1), 2014).
struct EndogeneityTest {
  double statistic = 0.0;          ///< F
  double numerator_freedom = 0.0;  ///< 0: the two motions have the same columns
  double denominator_freedom = 0.0;
  double p_value = 1.0;
};

/// A recording that could not be used; only identify() on several machines continues without it.
struct UnusedRecording {
  std::string source;
  std::string why;
};

struct StageSeconds {
  double read = 0.0;  ///< reading, filtering and building columns of the training recordings; part of compress
  double compress = 0.0;
  double solve = 0.0;
  double validate = 0.0;
};

/// Result of identify(). Plain data: report, JSON and page show nothing else.
struct Identification {
  IdentificationStatus status = IdentificationStatus::kNoData;
  std::string reason;  ///< reason of a status other than kDone, one line
  std::string robot;
  Method method = Method::kFeasible;
  JointWeights weights = JointWeights::kRange;
  PhysicalCondition condition = PhysicalCondition::kPseudoInertia;
  EffectSigns signs = EffectSigns::kPhysical;
  std::string prior;  ///< name of the prior's model; empty: none
  /// Preparation of the recordings; holds training recordings that were in memory, for diagnose().
  PreprocessingOptions preprocessing, test_preprocessing;
  double rows = 0.0;
  std::vector<BaseValue> base;
  double condition_number = 0.0;         ///< condition number of the unscaled base columns
  double condition_number_scaled = 0.0;  ///< condition number of the base columns scaled to norm one (thesis 5.26)
  double rank_gap = 0.0;
  double effective_samples = 0.0;  ///< effective sample size: rows corrected for autocorrelation
  bool feasible = false;           ///< every body's pseudo-inertia is positive definite
  double objective = 0.0;          ///< weighted sum of squares
  double unconstrained_objective = 0.0;  ///< objective of unconstrained least squares on the same rows
  double duality_gap = 0.0;
  /// The duality gap is rigorous, because the robot file bounds all parameters.
  bool certified = false;
  std::vector<std::string> active_constraints;
  std::vector<EndogeneityTest> endogeneity;  ///< (n) tests of kIv and kDidim; empty for other methods
  /// Standard parameters of the arm that these recordings do not determine.
  std::vector<std::string> undetermined;
  std::vector<std::string> still_joints;  ///< coordinates that never move
  std::vector<std::string> still_in_test;  ///< coordinates that hardly move in the test recordings, whose errors
                                           ///< therefore do not test their friction or inertia
  std::vector<RecordingError> train, test;
  PredictionError train_error, test_error;  ///< errors over all recordings, on every row as recorded
  /// Errors over all recordings, see RecordingError; empty where no row was interpolated or excluded.
  PredictionError train_repaired, test_repaired, train_without_excluded, test_without_excluded;
  VectorXd noise_floor;           ///< (n) relative noise floor of the training recordings
  VectorXd parameters;            ///< values of all standard parameters
  VectorXd parameter_deviations;  ///< standard deviations; NaN where only a combination is determined
  std::optional<Model> model;     ///< the arm with these values
  std::vector<CompressedRecording> factors;  ///< factors of the training recordings, which replace their samples
  /// Sentences on recordings that are unsuitable as training or test data.
  std::vector<std::string> warnings;
  /// Sentences on friction added to that of the robot file, and on every velocity that was replaced
  /// by the derivative of the position, see choose_velocities.
  std::vector<std::string> remarks;
  std::vector<UnusedRecording> unusable_recordings;  ///< recordings that could not be used
  std::optional<DriveGains> drive_gains;  ///< nullopt without known masses
  StageSeconds seconds;

  /// Status, rank gap, errors per joint, base parameters with standard deviations, as text.
  std::string report() const;
  /// One sentence: joints by state, with the recommendation, see verdict_of(); without a model the reason.
  std::string verdict() const;
};
/// Writes report().
std::ostream& operator<<(std::ostream& out, const Identification& id);

/// Identifies the arm from training recordings and validates it on test recordings, which are not used in the fit.
///
/// @param train, test  paths of recordings, or recordings in memory.
/// @throws InvalidInput  a file is bad or does not fit the arm. Data that do not suffice are a
/// status.
Identification identify(const Model& arm, const Recordings& train, const Recordings& test = {},
                        const IdentificationOptions& options = {});

/// True if every body and every effect has values, as in an identified model.
bool has_all_values(const Model& arm);

/// The arm with all its values declared as known.
Model with_fixed_parameters(const Model& arm);

/// Evaluates an arm with values on recordings without any fit. Errors, noise floors, series and
/// factors are filled as by identify(); the factors' right-hand sides are the residuals of the arm.
/// @throws InvalidInput  a parameter has no value; as identify().
Identification evaluate(const Model& arm, const Recordings& train, const Recordings& test = {},
                        const IdentificationOptions& options = {});

/// Identifies from one recording in memory, without a test.
Identification identify(const Model& arm, const Recording& recording,
                        const IdentificationOptions& options);

/// Writes the identified model as YAML, with date, version and the hashes of the input files (see
/// ModelOrigin). @throws InvalidInput  there is no model (see status), or the file cannot be
/// written.
/// @param command  name of the command, kept in the file.
/// @param robot    path of the robot file, if known.
void save(const Identification& id, const std::string& path,
          const std::string& command = "identify", const std::string& robot = {});

/// Writes an arm as YAML, without a record of where its values come from.
/// @throws InvalidInput  the file cannot be written.
void save(const Model& arm, const std::string& path);

}  // namespace veridyn
