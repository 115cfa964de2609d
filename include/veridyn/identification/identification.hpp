#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "veridyn/regressor/base_parameters.hpp"
#include "veridyn/regressor/joint_friction.hpp"
#include "veridyn/identification/compressed_recording.hpp"
#include "veridyn/identification/drive_gains.hpp"
#include "veridyn/identification/feasible_least_squares.hpp"

namespace veridyn {

enum class Method {
  kOls,       ///< ordinary least squares on the base parameters
  kWls,       ///< the rows of each joint weighted
  kFeasible,  ///< weighted, and every body physically possible
};

/// How the joints' rows are weighted by kWls and kFeasible.
enum class JointWeights {
  kRange,     ///< 1 / (max - min) of the joint's torque
  kResidual,  ///< 1 / standard deviation of the joint's residual in the fit with kRange
};

/// What feasible least squares asks of the effects' parameters.
enum class EffectSigns {
  kPhysical,  ///< friction, inertia and stiffness are not negative
  kAny,       ///< their sign is free, as in most published identifications; for comparison
};

struct IdentificationOptions {
  Method method = Method::kFeasible;
  JointWeights weights = JointWeights::kRange;
  PhysicalCondition condition = PhysicalCondition::kPseudoInertia;  ///< for kFeasible
  EffectSigns signs = EffectSigns::kPhysical;                       ///< for kFeasible
  /// Friction that is identified beside what the robot file has; remarks say which.
  JointFriction friction = JointFriction::kAuto;
  PreprocessingOptions preprocessing;
  std::optional<PreprocessingOptions>
      test_preprocessing;  ///< Preprocessing of held-out recordings; empty: the same
  /// kFeasible: pull toward this model's inertial parameters by the entropic divergence; its bodies
  /// need values.
  std::optional<Model> prior;
  double prior_weight = 1e-3;  ///< Weight of the prior, as a share of the weighted residual per body
  /// Loads that some training recordings carry: the drive gains are found first, see
  /// find_drive_gains(), and the arm is then identified from the recordings without a load.
  std::vector<KnownMass> known_masses;
  /// identify() of recordings: a velocity that `preprocessing` takes as recorded, and that is noisier
  /// than its position's derivative or wrong in scale, is taken from the position where the joint's
  /// torque is predicted better with it, by 2 % of its error or more, on the training recordings;
  /// Identification::preprocessing then says so. Factors, ranks and Filtering::kSignals, which
  /// filters the velocity itself, take it as it comes.
  bool choose_velocities = true;
  int threads = 0;  ///< recordings are read in parallel; 0: one thread per core
  /// Called with (what is being done, share done) between recordings.
  std::function<void(const std::string&, double)> progress;
};

enum class IdentificationStatus {
  kDone,
  kRankDeficient,  ///< the recordings leave base parameters of the arm undetermined; see
                   ///< `undetermined`
  kNoData,         ///< no usable samples are left
  kNotConverged,   ///< the feasible solve did not reach its gap; the best point is given
  kNoDriveGains,   ///< the known masses do not tell the drive gains, and the robot file has none
};

struct BaseValue {
  std::string name;
  std::string expression;
  std::string unit;
  double value = 0.0;
  double std = 0.0;  ///< block jackknife: autocorrelated samples do not count as independent
};

/// Errors of the identified model on one recording.
struct RecordingError {
  std::string source;
  PredictionError error;  ///< on every row, as recorded
  /// On every row, those of a late publisher filled in; empty where none was filled in.
  PredictionError repaired;
  /// The same without the moments that PreprocessingOptions::left_out excludes; empty where it
  /// excludes none of this recording.
  PredictionError without_excluded;
  FilledRows filled;
  long rows = 0;         ///< Rows of the file
  VectorXd noise_floor;  ///< relative, (n); empty where nothing repeats
  double period = 0.0;   ///< [s] of the motion; 0: it does not repeat
  PredictionSeries series;
};

/// A recording that was asked for and could not be used; only identify() on several machines goes
/// on without it.
struct UnusedRecording {
  std::string source;
  std::string why;
};

struct StageSeconds {
  double read = 0.0;  ///< reading, filtering and building columns of the training recordings
                      ///< included in compress
  double compress = 0.0;
  double solve = 0.0;
  double validate = 0.0;
};

/// What identify() found. Plain data: report, JSON and page show nothing else.
struct Identification {
  IdentificationStatus status = IdentificationStatus::kNoData;
  std::string reason;  ///< Reason of a status other than kDone, one line
  std::string robot;
  Method method = Method::kFeasible;
  JointWeights weights = JointWeights::kRange;
  PhysicalCondition condition = PhysicalCondition::kPseudoInertia;
  EffectSigns signs = EffectSigns::kPhysical;
  std::string prior;  ///< name of the prior's model; empty: none
  PreprocessingOptions preprocessing, test_preprocessing;
  double rows = 0.0;
  std::vector<BaseValue> base;
  double condition_number = 0.0;         ///< Condition number of the base columns as they are
  double condition_number_scaled = 0.0;  ///< Condition number of the base columns scaled to norm one (thesis 5.26)
  double rank_gap = 0.0;
  double effective_samples = 0.0;  ///< rows that count after autocorrelation
  bool feasible = false;           ///< every body's pseudo-inertia is positive definite
  double objective = 0.0;          ///< weighted sum of squares
  double unconstrained_objective =
      0.0;  ///< Objective of the same rows without conditions: never above `objective`
  double duality_gap = 0.0;
  bool certified = false;  ///< the gap is rigorous: the robot file bounds all parameters
  std::vector<std::string> active_constraints;
  std::vector<std::string> undetermined;  ///< standard parameters that these recordings leave open
                                          ///< though the arm has them
  std::vector<std::string> still_joints;  ///< coordinates that never move
  std::vector<RecordingError> train, test;
  PredictionError train_error, test_error;  ///< over all of them, on every row as recorded
  /// Where rows of any of them were filled in or excluded, over all of them, see RecordingError.
  PredictionError train_repaired, test_repaired, train_without_excluded, test_without_excluded;
  VectorXd noise_floor;           ///< relative, (n), of the training recordings
  VectorXd parameters;            ///< all standard parameters
  VectorXd parameter_deviations;  ///< NaN where only a combination is known
  std::optional<Model> model;     ///< the arm with these values
  std::vector<CompressedRecording>
      factors;  ///< the training recordings, for further questions without their samples
  /// Sentences on friction that the robot file does not have, and on every velocity that was taken
  /// from the position, see choose_velocities.
  std::vector<std::string> remarks;
  std::vector<UnusedRecording> left_out;  ///< Left out of the list, see there
  std::optional<DriveGains> drive_gains;  ///< Given where known masses were given
  StageSeconds seconds;

  /// Status, rank gap, errors per joint, base parameters with standard deviations, as text.
  std::string report() const;
};

/// Identifies the arm from training recordings and validates it on test recordings, which take no
/// part in the fit.
///
/// @param train, test  paths of recordings, or recordings in memory.
/// @throws InvalidInput  a file is bad or does not fit the arm. Data that cannot answer are a
/// status.
Identification identify(const Model& arm, const Recordings& train, const Recordings& test = {},
                        const IdentificationOptions& options = {});

/// True if every body and every effect has values: a MODEL, in the words of the tool.
bool has_all_values(const Model& arm);

/// The arm with all its values declared as facts.
Model frozen(const Model& arm);

/// What an arm with values predicts of recordings; nothing is fitted. Errors, noise floors, series
/// and factors are filled as by identify(); the factors' right-hand sides are what the arm leaves
/// unexplained.
/// @throws InvalidInput  a parameter has no value; as identify().
Identification evaluate(const Model& arm, const Recordings& train, const Recordings& test = {},
                        const IdentificationOptions& options = {});

/// One recording in memory, no test.
Identification identify(const Model& arm, const Recording& recording,
                        const IdentificationOptions& options);

/// Writes the identified model as YAML, with date, version and the hashes of the files that it was
/// made from (see ModelOrigin). @throws InvalidInput  there is no model (see status), or the file
/// cannot be written.
/// @param command  what made it, for readers of the file.
/// @param robot    path of the robot file, where it is known.
void save(const Identification& id, const std::string& path,
          const std::string& command = "identify", const std::string& robot = {});

}  // namespace veridyn
