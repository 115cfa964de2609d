// diagnosis/: causes of a model's residual; changes since an identified model, loads, a running arm, differences of two models.
#pragma once

#include <functional>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "veridyn/diagnosis/thresholds.hpp"
#include "veridyn/effects/cause.hpp"
#include "veridyn/identification/identification.hpp"
#include "veridyn/recordings/recording_quality.hpp"

namespace veridyn {

/// Treatment of dependences without a named cause.
enum class UnnamedForces {
  kReported,  ///< reported as findings, outside the extended model
  kKept,      ///< curves that can act as a joint force are written to the extended model as tabulated_force
};

struct DiagnosisOptions {
  DiagnosisOptions() { identification.weights = JointWeights::kResidual; }

  /// Preprocessing, weights and threads. Joints are weighted by their residual, because a missing
  /// effect on one joint would otherwise bias the parameters that it shares with others.
  IdentificationOptions identification;
  /// Candidates to test: names of effects, or causes as EFFECT:PLACE (see Cause); empty: all.
  std::vector<std::string> effects;
  int max_effects = 20;  ///< findings at most; contacts and plain friction do not count
  UnnamedForces unnamed = UnnamedForces::kReported;
  /// Provenance of the robot's values; nullopt: as given in its file.
  std::optional<RobotValues> values{};
  /// Thresholds of the steps before and after the search; those of the search itself are fixed.
  Thresholds thresholds;
  /// Called with (number tested, total) in every round of tests, by one thread at a time. diagnose()
  /// sets it; users set identification.progress.
  std::function<void(int, int)> testing{};
};

/// A parameter of a finding.
struct FoundParameter {
  std::string name;
  std::string unit;
  double value = 0.0;
  double low = 0.0;  ///< 95 % interval
  double high = 0.0;
};

/// An alternative cause that is confounded with a finding in these recordings.
struct Rival {
  Cause cause;
  std::string why;
  double share = 1.0;  ///< gain in place of the finding, relative to the finding's own
};

/// Result of cross-validation on the training recordings, with all other findings in the model. All findings of
/// diagnose() are confirmed; those of diagnose_at_rest() need not be.
enum class FindingStatus {
  kConfirmed,     ///< the finding lowers the error of parts that were held out
  kNotConfirmed,  ///< it does not
};
const char* name_of(FindingStatus status);

/// Effect of a finding on the error of the test recordings. kAgrees: it decreases, on the finding's own joint
/// too. Without a MODEL diagnose() removes causes that the test recordings contradict; for a MODEL it reports
/// them.
enum class Agreement { kAgrees, kContradicts, kNotMeasured };
const char* name_of(Agreement agreement);

/// A point of a curve: values of the signals, torque, 95 % band.
struct CurvePoint {
  std::vector<double> at;  ///< one value per signal
  double value = 0.0;      ///< [N m] or [N], relative to its mean over the training recordings
  double low = 0.0, high = 0.0;
};

/// Dependence of a residual on signals that does not have the shape of a known cause.
struct UnnamedShape {
  static constexpr const char* kName = "unnamed";
  /// One or two of "q1".., "dq1".., "tau1".. (the model's torque), "history1".. (signed travel since the last reversal)
  /// and "t" (since the recording began).
  std::vector<std::string> signals;
  std::vector<std::string> units;
  /// Only the sign of the second signal, a velocity, matters: one curve for each direction.
  bool on_sides = false;
  std::string words;  ///< description: "one-sided: nothing below 0.43 rad, ..."
  std::string effort;  ///< unit of the values
  std::vector<CurvePoint> curve;
  bool kept = false;   ///< the extended model has it as a table
  double share = 0.0;  ///< share of the test recordings' mean square residual that it predicts
};

struct Finding {
  int rank = 0;
  Cause cause;                      ///< words_of() converts it to text
  std::optional<JointIndex> joint;  ///< acting_joint() of the cause; nullopt: the whole arm
  std::optional<JointIndex> from;   ///< the other joint of a coupling or of a crosstalk
  std::string phrase;               ///< description without the place: "a spring of 2 N m/rad"
  std::string remark;               ///< a sentence on its size if that is unusual
  std::string source;               ///< the recording with the contact
  std::string unit;                 ///< unit of the first parameter
  std::vector<FoundParameter> parameters;
  double p_value = 1.0;
  /// Decrease of the sum over joints of ln(mean square residual) in cross-validation on the training
  /// recordings.
  double gain = 0.0;
  /// (n) relative error on every row of the test recordings as recorded, before and after the
  /// finding was added to those above it.
  VectorXd test_before, test_after;
  /// (n) relative error in cross-validation on the training recordings, without and with it; the
  /// status follows from it.
  VectorXd folds_before, folds_after;
  /// For a contact: (n) relative error of the test recordings outside of all contacts.
  VectorXd test_outside;
  double explains = 0.0;  ///< share of the removable held-out error; negative if it grows

  Agreement held_out() const;
  FindingStatus status = FindingStatus::kConfirmed;
  bool main = true;  ///< one of DiagnosisSummary::main
  std::vector<Rival> rivals;
  std::optional<UnnamedShape> shape;  ///< set for a finding without a named cause
  std::string text;  ///< sentence() of it
};

/// Place and phrase of a finding in one sentence.
std::string sentence(const Model& arm, const Finding& finding);
/// Finding::text.
std::ostream& operator<<(std::ostream& out, const Finding& finding);

struct NotSupported {
  Cause cause;
  double p_value = 1.0;
  std::string why;
};

struct CannotTell {
  std::string effect;
  std::optional<Cause> cause;  ///< nullopt: at any place
  std::string why;
};

/// The recording that would separate confounded causes, or show the curve of an unnamed dependence best.
struct NextExperiment {
  std::vector<Cause> between;  ///< the two causes to separate; empty: none
  std::string shows;  ///< "what joint 1 depends on over q1", where `between` is empty
  int slow_passes = 0;         ///< required ExcitationOptions::slow_passes

  /// Cause k of `between` as text: "payload on wrist", "torque_gain on joint 2".
  std::string words(const Model& arm, size_t k) const;
};

/// Verdict on one joint.
enum class JointState {
  kAtFloor,     ///< the residual contains nothing predictable
  kNamed,       ///< named findings explain the residual, or most of it
  kUnnamed,  ///< the residual depends on signals of the recordings in a form that no known cause has
  kCannotTell,  ///< the residual is above the floor, and the recordings do not show its cause
};
const char* name_of(JointState state);

/// Method by which a noise floor was estimated.
enum class FloorSource {
  kRepeats,     ///< difference between repeats of a motion
  kRegression,  ///< held-out residual of a flexible regression on the motion
};
const char* name_of(FloorSource source);

/// Relative errors of one joint that add up, on every row of the held-out recordings: held_out = floor +
/// removable. Named findings remove held_out - extended of it, unnamed ones extended - left.
struct JointVerdict {
  JointIndex joint;
  double held_out = 0.0;  ///< error of the unmodified model
  double floor = 0.0;
  double removable = 0.0;
  double extended = 0.0;  ///< error with the named findings
  double left = 0.0;      ///< error with the unnamed findings as well
  FloorSource source = FloorSource::kRegression;
  JointState state = JointState::kAtFloor;
  std::string why;  ///< reason of kCannotTell
};

/// Overview of a diagnosis.
struct DiagnosisSummary {
  int main = 0;  ///< number of findings that together explain nine tenths of the error; they come first
  double explained_by_main = 0.0;  ///< share of the removable held-out error
  double explained_by_all = 0.0;
  std::vector<JointIndex> worse_joints;  ///< their held-out error is larger with the extended model than with the baseline
};

/// Result of a diagnosis. Plain data: text, JSON and page show exactly this.
struct Diagnosis {
  bool changes = false;  ///< the robot was an identified model: findings are changes since its identification
  /// True: findings that are not main form their own list in JSON and are counted in one line of the report;
  /// false: they are listed after the others.
  bool small_apart = false;
  bool mended = false;  ///< corrections for the faults in `data_quality` were applied to recordings or robot
  DiagnosisSummary summary;
  Identification baseline;  ///< the unmodified robot; a MODEL's values are not fitted
  Identification extended;  ///< with the findings
  std::vector<Finding> findings;
  std::vector<JointVerdict> joints;  ///< one for each
  /// Groups of joints whose positions are collinear in all training recordings:
  /// dependences on one of them cannot be separated from the others.
  std::vector<std::vector<JointIndex>> moving_as_one;
  std::vector<NotSupported> not_supported;
  std::vector<CannotTell> cannot_tell;
  std::vector<RecordingQuality> data_quality;
  std::vector<ExcludedInterval> excluded_intervals;   ///< intervals excluded because of a disturbance of the recording
  /// Sentences on velocities that were derived from positions, and on constants of the model's own effects that
  /// changed in the extended model.
  std::vector<std::string> remarks;
  NextExperiment next_experiment;  ///< empty if no causes are confounded
  bool provisional = false;        ///< there is only one training recording: names are provisional
  /// Friction, offsets and rotor inertia of the extended model, if the file has no friction and plain
  /// friction was added; these are no findings.
  std::vector<JointNumber> friction;
  std::string friction_remark;     ///< text on the friction that was added; empty: none was
  /// The arm with the findings, or the baseline's; without joints if nothing could be fitted.
  Model model;
  int hypotheses = 0;              ///< number of candidates tested
  double seconds = 0.0;

  /// Place and phrase of one of the findings in one sentence.
  std::string sentence(const Finding& finding) const;

  /// One sentence: the first finding with the held-out error of all findings; "none" if every joint is at its
  /// floor; otherwise the reason for which the recordings do not show a cause.
  std::string verdict() const;

  /// False if the recordings do not allow a search: every joint's verdict states the reason.
  bool has_answer() const;

  /// @param next_command  command line that designs the next experiment; empty: the report names
  /// only the causes to separate.
  std::string report(const std::string& next_command = "") const;
};

/// The report.
std::ostream& operator<<(std::ostream& out, const Diagnosis& diagnosis);

/// Writes the model with date, version and the hashes of the input files, as save() of an Identification.
/// @throws InvalidInput  there is no model, or the file cannot be written.
void save(const Diagnosis& diagnosis, const std::string& path, const std::string& command = "diagnose",
          const std::string& robot = {});

/// Finds the physical causes of the torques that the robot's model leaves unexplained. Causes are selected
/// and fitted on the training recordings, and so is the extended model. The test recordings measure the gain;
/// for a robot file, causes that they contradict are removed.
///
/// An arm without values is identified first, and every fit estimates its parameters again. For a MODEL the
/// findings are **changes since its identification**, such as a payload, a drive gain, an encoder's zero or a
/// change of friction: its parameters vary only within their covariance.
///
/// One search compares effects, errors of channels, constants of the robot file, the direction of gravity, loads and
/// curves without a name by one score: the cross-validated error and the prior probability of a cause (docs/diagnosis.md).
///
/// @throws InvalidInput  as identify(). If the robot cannot be identified, baseline.status has the
/// reason and nothing else is filled.
Diagnosis diagnose(const Model& arm, const Recordings& train, const Recordings& test,
                   const DiagnosisOptions& options = {});

/// diagnose() of an identification, with its training recordings, their preprocessing and the friction that it added.
/// Recordings in memory are not read again, and the first fit uses the identification's factors. An identification
/// without a model is returned as the baseline.
/// @throws InvalidInput  the identification has factors only, without recordings; as identify().
Diagnosis diagnose(const Identification& fit, const Recordings& test, const DiagnosisOptions& options = {});

}  // namespace veridyn
