#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "veridyn/diagnosis/thresholds.hpp"
#include "veridyn/effects/cause.hpp"
#include "veridyn/identification/identification.hpp"
#include "veridyn/recordings/recording_quality.hpp"

namespace veridyn {

/// What the extended model contains.
enum class ExtendedModel {
  kAllFindings,    ///< every finding that was accepted
  kConfirmedOnly,  ///< those that are confirmed, see FindingStatus
};

/// What becomes of dependences without a name.
enum class UnnamedForces {
  kReported,  ///< they are findings, and the extended model is without them
  kKept,      ///< those that a force can have are tables (tabulated_force) of the extended model
};

struct DiagnosisOptions {
  DiagnosisOptions() { identification.weights = JointWeights::kResidual; }

  /// Preprocessing, weights and threads are taken from here. Joints are weighted by their residual:
  /// what the model lacks on one joint would otherwise spoil the parameters that it shares with
  /// others.
  IdentificationOptions identification;
  /// What to ask about: names of effects, or causes as EFFECT:PLACE (see Cause); empty: all that the
  /// tool knows.
  std::vector<std::string> effects;
  int max_effects = 20;  ///< findings at most; contacts and plain friction do not count
  ExtendedModel extended = ExtendedModel::kConfirmedOnly;
  UnnamedForces unnamed = UnnamedForces::kReported;
  /// What the values of the robot are; nothing: as its file says.
  std::optional<RobotValues> values{};
  /// An effect is accepted when the sum over joints of ln(held-out mean square error) falls by more
  /// than `smallest_gain`, in the mean over the folds (recordings, or phases of the period of a
  /// single one), in all folds but one or beyond chance by their signed ranks, and when the p value
  /// of its parameters over clusters (phases of the period, repeats merged) is below `significance`
  /// over the number of causes asked about. With one recording only causes that depend on place are held to the number of causes:
  /// names are provisional then.
  Thresholds thresholds;
};

/// One number of a finding.
struct FoundParameter {
  std::string name;
  std::string unit;
  double value = 0.0;
  double low = 0.0;  ///< 95 % interval
  double high = 0.0;
};

/// Another cause that these recordings cannot separate from a finding.
struct Rival {
  Cause cause;
  std::string why;
};

/// What held-out parts of the training recordings say of a finding beside all others. The held-out
/// recordings take no part in it: they measure what was chosen without them, see Agreement.
enum class FindingStatus {
  kConfirmed,     ///< the parts are predicted better with it, its own joint too
  kNotConfirmed,  ///< they are not, or it lost its name after the last fit
};
const char* name_of(FindingStatus status);

/// Whether the held-out recordings are predicted better with a finding, on its own joint too.
enum class Agreement { kAgrees, kContradicts, kNotMeasured };
const char* name_of(Agreement agreement);

/// A point of a curve: where on its signals, the torque there and its 95 % band.
struct CurvePoint {
  std::vector<double> at;  ///< one for each signal
  double value = 0.0;      ///< [N m] or [N], its mean over the training recordings taken away
  double low = 0.0, high = 0.0;
};

/// What a residual depends on where no cause of the list has that shape.
struct UnnamedShape {
  static constexpr const char* kName = "unnamed";
  /// One or two of "q1".., "dq1".., "ddq1".., "tau1".. (the model's torque), "history1".. (signed
  /// travel since the last reversal) and "t" (since the recording began).
  std::vector<std::string> signals;
  std::vector<std::string> units;
  /// The second signal is a velocity of which only the sign counts: one curve for each direction.
  bool on_sides = false;
  std::string words;  ///< "one-sided: nothing below 0.43 rad, ..."
  std::string effort = "N m";
  std::vector<CurvePoint> curve;
  bool kept = false;   ///< the extended model has it as a table
  double share = 0.0;  ///< of the mean square that is left over, on the held-out recordings
  /// Other signals that would predict as much in their place: the recordings cannot tell.
  std::vector<std::vector<std::string>> as_good;
};

struct Finding {
  int rank = 0;
  Cause cause;                      ///< words_of() gives the words for it
  std::optional<JointIndex> joint;  ///< acting_joint() of the cause; nothing: the whole arm
  std::string phrase;               ///< what was found, without its place: "a spring of 2 N m/rad"
  std::string remark;               ///< a sentence on its size where that is unusual
  std::string source;               ///< the recording that a contact is in
  std::string unit;                 ///< Unit of the first parameter
  std::vector<FoundParameter> parameters;
  double p_value = 1.0;
  double gain = 0.0;  ///< fall of the sum over joints of ln(mean square) on held-out folds of the
                      ///< training recordings
  /// (n) relative error on every row of the test recordings as recorded, without and with it, in
  /// order of discovery.
  VectorXd test_before, test_after;
  /// (n) relative error on held-out parts of the training recordings, without and with it: what its
  /// status is made of.
  VectorXd folds_before, folds_after;
  /// Of a contact: (n) the same on the rows outside of all contacts.
  VectorXd test_outside;
  double explains = 0.0;  ///< share of the removable held-out error; negative where it grows

  Agreement held_out() const;
  FindingStatus status = FindingStatus::kConfirmed;
  std::string why_not;  ///< of one that is not confirmed although its error on the parts fell
  bool main = true;  ///< false: one of the small ones, see DiagnosisSummary
  std::vector<Rival> rivals;
  std::optional<UnnamedShape> shape;  ///< of a finding without a name
};

/// Place and phrase of a finding in one sentence.
std::string sentence(const Model& arm, const Finding& finding);

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

/// The recording that would separate what these recordings cannot, or show a curve without a name
/// best.
struct NextExperiment {
  std::vector<Cause> between;  ///< the two causes; empty: there is nothing to separate
  std::string shows;           ///< "what joint 1 depends on over q1"; empty where `between` is not
  int slow_passes = 0;         ///< ExcitationOptions::slow_passes that it needs

  /// One of the two in words: "payload on wrist", "torque_gain on joint 2".
  std::string words(const Model& arm, size_t k) const;
};

/// What a verdict says of one joint.
enum class JointState {
  kAtFloor,     ///< nothing is left over that could be predicted
  kNamed,       ///< findings with names explain what is left over, or most of it
  kUnnamed,     ///< it depends on signals of the recordings as no cause of the list does
  kCannotTell,  ///< there is more than the floor, and the recordings do not tell of what
};
const char* name_of(JointState state);

/// Where a noise floor comes from.
enum class FloorSource {
  kRepeats,     ///< what differs between repeats of a motion
  kRegression,  ///< what a flexible regression of the motion leaves of the residual, held out
};
const char* name_of(FloorSource source);

/// Errors of one joint that add up, relative, on every row of the held-out recordings:
/// held_out = floor + removable, and of that the findings with names take held_out - extended, those
/// without take extended - left.
struct JointVerdict {
  JointIndex joint;
  double held_out = 0.0;  ///< of the model as it stands
  double floor = 0.0;
  double removable = 0.0;
  double extended = 0.0;  ///< with the findings that have names
  double left = 0.0;      ///< with those that have none beside them
  FloorSource source = FloorSource::kRegression;
  JointState state = JointState::kAtFloor;
  std::string why;  ///< of kCannotTell
};

/// What a reader must see first.
struct DiagnosisSummary {
  int main = 0;                    ///< findings that matter; they come first
  double explained_by_main = 0.0;  ///< share of the removable held-out error
  double explained_by_all = 0.0;
  std::vector<int> worse_joints;   ///< from 1: the extended model predicts them worse than the
                                   ///< baseline does, on the held-out recordings
};

/// What a diagnosis found. Plain data: text, JSON and page show exactly this.
struct Diagnosis {
  bool changes = false;     ///< the robot was a MODEL: findings say what changed since
  DiagnosisSummary summary;
  Identification baseline;  ///< the robot as it stands; a MODEL's values are not fitted anew
  Identification extended;  ///< with the findings
  std::vector<Finding> findings;
  std::vector<JointVerdict> joints;  ///< one for each
  /// Groups of joints, from 0, whose positions are straight lines of one another in all training
  /// recordings: what depends on one of them cannot be told from the others.
  std::vector<std::vector<int>> moving_as_one;
  std::vector<NotSupported> not_supported;
  std::vector<CannotTell> cannot_tell;
  std::vector<RecordingQuality> data_quality;
  std::vector<LeftOut> left_out;   ///< moments that belong to a recording and not to the arm
  /// What the diagnosis did beside naming causes: velocities taken from positions, constants of the
  /// model's own effects that the extended model has otherwise.
  std::vector<std::string> remarks;
  NextExperiment next_experiment;  ///< empty where nothing is left to separate
  bool provisional = false;        ///< one training recording only: names are provisional
  /// Friction, offsets and rotor inertia of the extended model, where the file has no friction and
  /// the arm was asked about with plain friction from the start; no findings.
  std::vector<JointNumber> friction;
  std::string friction_remark;     ///< what the file lacks, in words; empty: nothing was added
  int hypotheses = 0;              ///< how many were asked
  double seconds = 0.0;

  /// Place and phrase of one of the findings in one sentence.
  std::string sentence(const Finding& finding) const;

  /// One sentence: the first finding, and what the held-out recordings hold against the whole;
  /// "none" where every joint is at its floor.
  std::string verdict() const;

  /// @param next_command  how the next experiment is made, as whoever asks would type it; empty:
  ///                      what it separates is said alone.
  std::string report(const std::string& next_command = "") const;
};

/// Asks which physical causes the recordings accept beyond the robot's own model. Causes are
/// selected, confirmed and fitted on the training recordings only, and so is the extended model; the
/// test recordings measure what that gained. Of a test recording itself only faults are looked for: moments of contact, snags, a
/// velocity that is not the derivative of its position (it is then taken from the position).
///
/// An arm without values is identified first, and every fit leaves its parameters free. An arm with
/// values (a MODEL) is taken at its word, and findings say **what changed since**: a payload, a
/// drive gain, an encoder's zero, friction that is not what it was.
///
/// Order of the questions: moments of a recording (contacts, snags), plain friction of joints for
/// which the file has none (all of them together), errors of the channels and wrong constants of
/// the robot file, and then all other causes together, the channels first where they explain as
/// much. No range of belief decides between causes: an unusual size is a remark.
///
/// @throws InvalidInput  as identify(). Where the robot cannot be identified, baseline.status says
/// so and nothing else is filled.
Diagnosis diagnose(const Model& arm, const Recordings& train, const Recordings& test,
                   const DiagnosisOptions& options = {});

}  // namespace veridyn
