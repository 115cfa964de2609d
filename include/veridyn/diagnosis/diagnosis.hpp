// diagnosis/: what a model leaves unexplained, and why; changes against a model, loads, a running arm, two models.
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

/// Findings that are listed; the extended model contains all with a name.
enum class ExtendedModel {
  kAllFindings,    ///< every finding
  kConfirmedOnly,  ///< those that together explain nine tenths; the others stand apart
};

/// Treatment of dependences without a named cause.
enum class UnnamedForces {
  kReported,  ///< reported as findings, outside the extended model
  kKept,      ///< those that can be a force become tables (tabulated_force) of the extended model
};

struct DiagnosisOptions {
  DiagnosisOptions() { identification.weights = JointWeights::kResidual; }

  /// Preprocessing, weights and threads. Joints are weighted by their residual, because a missing
  /// effect on one joint would otherwise bias the parameters that it shares with others.
  IdentificationOptions identification;
  /// Candidates to test: names of effects, or causes as EFFECT:PLACE (see Cause); empty: all.
  std::vector<std::string> effects;
  int max_effects = 20;  ///< findings at most; contacts and plain friction do not count
  ExtendedModel extended = ExtendedModel::kConfirmedOnly;
  UnnamedForces unnamed = UnnamedForces::kReported;
  /// Provenance of the robot's values; nullopt: as its file says.
  std::optional<RobotValues> values{};
  /// Around the search, which decides by its own numbers; with a single recording names are provisional.
  Thresholds thresholds;
  /// Called with (tested, of how many) during every round of tests, from any thread but one at a
  /// time; diagnose() sets it, and reports through identification.progress.
  std::function<void(int, int)> testing{};
};

/// One number of a finding.
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
};

/// What held-out parts of the training recordings say of a finding beside all others. A search accepts only what is
/// confirmed; of a robot file, what the held-out recordings contradict is no finding either, so that the gain on them is
/// that of causes which passed on them once. A diagnosis of poses at rest reports both.
enum class FindingStatus {
  kConfirmed,     ///< the parts are predicted better with it
  kNotConfirmed,  ///< they are not
};
const char* name_of(FindingStatus status);

/// Whether the held-out recordings are predicted better with a finding, on its own joint too.
enum class Agreement { kAgrees, kContradicts, kNotMeasured };
const char* name_of(Agreement agreement);

/// A point of a curve: where on its signals, the torque there and its 95 % band.
struct CurvePoint {
  std::vector<double> at;  ///< one value per signal
  double value = 0.0;      ///< [N m] or [N], relative to its mean over the training recordings
  double low = 0.0, high = 0.0;
};

/// Dependence of a residual on signals, where no known cause has that shape.
struct UnnamedShape {
  static constexpr const char* kName = "unnamed";
  /// One or two of "q1".., "dq1".., "tau1".. (the model's torque), "history1".. (signed travel since the last reversal)
  /// and "t" (since the recording began).
  std::vector<std::string> signals;
  std::vector<std::string> units;
  /// The second signal is a velocity of which only the sign counts: one curve for each direction.
  bool on_sides = false;
  std::string words;  ///< "one-sided: nothing below 0.43 rad, ..."
  std::string effort;  ///< unit of the values
  std::vector<CurvePoint> curve;
  bool kept = false;   ///< the extended model has it as a table
  double share = 0.0;  ///< of the mean square that is left over, on the held-out recordings
};

struct Finding {
  int rank = 0;
  Cause cause;                      ///< words_of() converts it to text
  std::optional<JointIndex> joint;  ///< acting_joint() of the cause; nothing: the whole arm
  std::optional<JointIndex> from;   ///< the other joint of a coupling or of a crosstalk
  std::string phrase;               ///< description without the place: "a spring of 2 N m/rad"
  std::string remark;               ///< a sentence on its size if that is unusual
  std::string source;               ///< the recording with the contact
  std::string unit;                 ///< unit of the first parameter
  std::vector<FoundParameter> parameters;
  double p_value = 1.0;
  /// Decrease of the sum over joints of ln(mean square) on held-out folds of the training
  /// recordings.
  double gain = 0.0;
  /// (n) relative error on every row of the test recordings as recorded, without and with the
  /// finding, in order of discovery.
  VectorXd test_before, test_after;
  /// (n) relative error on held-out parts of the training recordings, without and with it: what its
  /// status is made of.
  VectorXd folds_before, folds_after;
  /// For a contact: (n) the same on the rows outside of all contacts.
  VectorXd test_outside;
  double explains = 0.0;  ///< share of the removable held-out error; negative where it grows

  Agreement held_out() const;
  FindingStatus status = FindingStatus::kConfirmed;
  bool main = true;  ///< false: one of the small ones, see DiagnosisSummary
  std::vector<Rival> rivals;
  std::optional<UnnamedShape> shape;  ///< set for a finding without a named cause
  std::string text;  ///< sentence() of it
};

/// Place and phrase of a finding in one sentence.
std::string sentence(const Model& arm, const Finding& finding);
/// The sentence, as diagnose() wrote it down.
std::ostream& operator<<(std::ostream& out, const Finding& finding);

struct NotSupported {
  Cause cause;
  double p_value = 1.0;
  std::string why;
};

struct CannotTell {
  std::string effect;
  std::optional<Cause> cause;  ///< nothing: wherever it were
  std::string why;
};

/// The recording that would separate confounded causes, or show best the curve of an unnamed
/// dependence.
struct NextExperiment {
  std::vector<Cause> between;  ///< the two causes to separate; empty: none
  std::string shows;  ///< "what joint 1 depends on over q1"; empty unless `between` is empty
  int slow_passes = 0;         ///< ExcitationOptions::slow_passes that it needs

  /// One of the two as text: "payload on wrist", "torque_gain on joint 2".
  std::string words(const Model& arm, size_t k) const;
};

/// Verdict on one joint.
enum class JointState {
  kAtFloor,     ///< the residual contains nothing predictable
  kNamed,       ///< named findings explain the residual, or most of it
  kUnnamed,  ///< the residual depends on signals of the recordings in a way that no known cause has
  kCannotTell,  ///< the residual is above the floor, and the recordings do not show its cause
};
const char* name_of(JointState state);

/// Method by which a noise floor was estimated.
enum class FloorSource {
  kRepeats,     ///< difference between repeats of a motion
  kRegression,  ///< held-out residual of a flexible regression on the motion
};
const char* name_of(FloorSource source);

/// Errors of one joint that add up, relative, on every row of the held-out recordings: held_out =
/// floor + removable; named findings remove held_out - extended of it, unnamed ones extended -
/// left.
struct JointVerdict {
  JointIndex joint;
  double held_out = 0.0;  ///< of the unmodified model
  double floor = 0.0;
  double removable = 0.0;
  double extended = 0.0;  ///< with the named findings
  double left = 0.0;      ///< with the unnamed ones as well
  FloorSource source = FloorSource::kRegression;
  JointState state = JointState::kAtFloor;
  std::string why;  ///< reason of kCannotTell
};

/// Overview of a diagnosis.
struct DiagnosisSummary {
  int main = 0;                    ///< findings that matter; they come first
  double explained_by_main = 0.0;  ///< share of the removable held-out error
  double explained_by_all = 0.0;
  std::vector<int> worse_joints;   ///< from 1: the extended model predicts them worse than the
                                   ///< baseline does, on the held-out recordings
};

/// Result of a diagnosis. Plain data: text, JSON and page show exactly this.
struct Diagnosis {
  bool changes = false;  ///< the robot was a MODEL: findings are changes since its identification
  /// Findings that are not main stand apart: a list of their own in JSON, one line in text.
  bool small_apart = false;
  bool mended = false;  ///< recordings or robot were transformed as the faults in `data_quality` say
  DiagnosisSummary summary;
  Identification baseline;  ///< the unmodified robot; the values of a MODEL are not fitted
  Identification extended;  ///< with the findings
  std::vector<Finding> findings;
  std::vector<JointVerdict> joints;  ///< one for each
  /// Groups of joints, from 0, whose positions are collinear in all training recordings:
  /// dependences on one of them cannot be separated from the others.
  std::vector<std::vector<int>> moving_as_one;
  std::vector<NotSupported> not_supported;
  std::vector<CannotTell> cannot_tell;
  std::vector<RecordingQuality> data_quality;
  std::vector<ExcludedInterval> excluded_intervals;   ///< intervals excluded because of a disturbance of the recording
  /// Actions of the diagnosis beside naming causes: velocities derived from positions, and
  /// constants of the model's own effects that changed in the extended model.
  std::vector<std::string> remarks;
  NextExperiment next_experiment;  ///< empty if there is nothing to separate
  bool provisional = false;        ///< one training recording only: names are provisional
  /// Friction, offsets and rotor inertia of the extended model, where the file has no friction and
  /// plain friction was added from the start; these are no findings.
  std::vector<JointNumber> friction;
  std::string friction_remark;     ///< text on the friction that was added; empty: none was
  /// The arm with the findings, or as the baseline has it; without joints if nothing could be fitted.
  Model model;
  int hypotheses = 0;              ///< number of candidates tested
  double seconds = 0.0;

  /// Place and phrase of one of the findings in one sentence.
  std::string sentence(const Finding& finding) const;

  /// One sentence: the first finding, and the held-out error of the whole; "none" where every joint
  /// is at its floor.
  std::string verdict() const;

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

/// Asks which physical causes the recordings accept beyond the robot's own model. Causes are
/// selected, confirmed and fitted on the training recordings only, and so is the extended model; the
/// test recordings measure the gain. A test recording itself is checked for faults only: contacts,
/// a velocity that is not the derivative of its position (which is then used instead).
///
/// An arm without values is identified first, and every fit leaves its parameters free. The values
/// of a MODEL are kept fixed, and findings say **what changed since**: a payload, a drive gain, an
/// encoder's zero, a change of friction.
///
/// One search explains what the fit leaves: effects, errors of channels, constants of the robot file, the direction of
/// gravity, loads and curves without a name compete by one held-out score and their prices; an unusual size is a remark.
///
/// @throws InvalidInput  as identify(). If the robot cannot be identified, baseline.status has the
/// reason and nothing else is filled.
Diagnosis diagnose(const Model& arm, const Recordings& train, const Recordings& test,
                   const DiagnosisOptions& options = {});

/// Asks what an identification leaves unexplained, on its recordings, with its preparation of them and
/// the friction that it added. Recordings in memory are not read again, and the first fit is solved from
/// the identification's factors. An identification without a model comes back as the baseline.
/// @throws InvalidInput  it was made of factors alone; as identify().
Diagnosis diagnose(const Identification& fit, const Recordings& test, const DiagnosisOptions& options = {});

}  // namespace veridyn
