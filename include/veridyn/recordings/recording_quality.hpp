#pragma once

#include <optional>
#include <string>
#include <vector>

#include "veridyn/model/model.hpp"
#include "veridyn/recordings/recording.hpp"
#include "veridyn/recordings/recording_period.hpp"

namespace veridyn {

enum class Severity {
  kInfo,     ///< information; the data are used unchanged
  kWarning,  ///< the data are usable, but a result may suffer
  kFault     ///< a result from these data would be wrong
};

/// Kinds of findings about recordings, with the meaning of QualityFinding::value and share, in the alphabetical order of
/// their names. For mistakes that check_against() finds, `value` is the relative error of the torque after the correction.
enum class QualityKind {
  kAbsurdNumbers,  ///< beyond +-1e6 or infinite; share of rows; value: count; gaps for all other checks
  kBeyondEffort,  ///< a torque is several times the effort of the robot file; value: that ratio
  kBeyondLimits,  ///< a position beyond the limits of the robot file; value: the furthest
  kBeyondSpeed,  ///< a speed beyond the limit of the robot file; value: their ratio
  kBrakes,  ///< torques of an arm at rest are not those that hold it
  kChangedMidway,  ///< the rows before or after a moment do not fit the others
  kConstantSignal,  ///< a signal never differs from its first value
  kCounts,  ///< positions are counts of an encoder
  kCurrent,  ///< torques are motor currents
  kDegrees,  ///< q or dq seems to be in degrees (dq 57.3 times too large; q beyond 4 pi most of the time)
  kDhConvention,  ///< the rows of the robot file follow the other convention
  kEncoderZero,  ///< a joint's position is counted from another zero, near a quarter turn or half a turn away
  kErrorsInVariables,  ///< noise of the motion biases least squares; value: number of parameters; share of all
  kGaps,  ///< NaN; share of rows; value: longest run [rows]
  kGivenUnit,  ///< the recording fits without a unit that was given
  kGravity,  ///< it has another direction, or the torques contain none
  kHardlyMoves,  ///< a joint moves over a small part of its range; value: that share
  kIrregularTime,  ///< value: mean rate [Hz]; steps differ by more than 5 %
  kJointAtRest,  ///< q stays within 5 mrad or 5 mm; value: its range
  kJumps,  ///< position steps that the neighbouring motion cannot explain; value: the largest
  kMillimetres,  ///< positions in millimetres
  kMissingRows,  ///< steps above 1.5 median steps; share of rows lost; value: longest step [s]
  kMotorSide,  ///< positions in front of a gear
  kMoveAsOne,  ///< positions of joints are collinear
  kNoMotion,  ///< no joint moves
  kNoSign,  ///< no torque of any moving joint is negative, or one of one sign does not follow from the motion
  kNoTorque,  ///< neither torques nor currents, or all zero
  /// the recording leaves base parameters of the arm undetermined or nearly so, and wrong signals would fit as well;
  /// value: number of determined ones. No other fault of check_against() is reported then
  kNotCompared,
  kOverflow,  ///< torque steps from one end of its range to the other while the joint moves on; value: that end
  kPeriod,  ///< the motion repeats; value: the period [s]
  kPositionSign,  ///< a joint's position is counted with the opposite sign
  kRateContradiction,  ///< dq = value * dq/dt of q, the same value on all moving joints
  kRemark,  ///< remark of the reader (a truncated file, repeated time stamps)
  kSameColumn,  ///< the torques of two joints are equal in every row
  kSampleRate,  ///< value: inverse of the median step [Hz]
  kSaturation,  ///< torque or current stays at its extreme; value: that limit; share of rows
  kShareOfRange,  ///< positions are shares of the range
  kShortRecording,  ///< too few rows or too short for any checks except those of numbers and time
  kStaleRows,  ///< rows equal to the one before in all signals while the arm moves; value: longest run [rows]
  kStaleSignal,  ///< the same for a single signal
  kStartUpTransient,  ///< torque rings when the recording starts; value: until when [s]
  kSwappedJoints,  ///< two joints are exchanged, in their torques, in their motion, or in both
  kTimeUnit,  ///< times are in another unit; value: median step [s]
  kTorqueClock,  ///< torques were measured by another clock
  kTorqueDelay,  ///< torques lag or lead the motion
  kTorqueFilter,  ///< torques passed a low-pass
  kTorqueQuantised,  ///< torque or current is quantised coarsely; value: step; share: step by the signal's range
  kTorqueSign,  ///< torques of a joint, or of all, have the wrong sign
  kTorqueUnit,  ///< torques in another unit, as shares of the limits, in front of gears
  kTurns,  ///< positions or velocities in turns
  kTwoRates,  ///< rows come at another rate for a while; value: that rate [Hz]
  kUnexplained,  ///< no hypothesis explains most of the torque: the recording of another arm; a warning: nothing explains a part of a joint's torque
  kValues,  ///< free parameters explain the torque far better than known values of the robot
  kVelocityDelay,  ///< dq lags the derivative of q (cross-correlation); value [s]
  kVelocityNoise,  ///< dq is noisier than the derivative of q; value: rms noise; share of the range
  kVelocityQuantised,  ///< dq is quantised coarsely; value: step; share: step by the signal's range
  kVelocityScale,  ///< as rate_contradiction, on this joint only
  kVelocitySign,  ///< as rate_contradiction, with a value near -1
  kVelocityUnrelated,  ///< dq is not the derivative of q; value: their correlation
  /// a joint moves too little to separate a spring from a load; value: share of a spring's torque that is not
  /// gravity's
  kWeakMotion,
  kZeroSignal,  ///< a signal is always zero
};

/// The kind's name in files and text: "stale_rows".
const char* name_of(QualityKind kind);

/// One finding of check_recording() or check_against(), as plain data.
struct QualityFinding {
  std::string file;
  QualityKind kind = QualityKind::kRemark;
  std::string signal;  ///< "q", "dq", ...; empty: the whole file
  std::optional<JointIndex> joint = {};  ///< nullopt: all joints
  /// Affected share of the rows (or of the range), 0 to 1; NaN: not applicable.
  double share = 0.0;
  double value = 0.0;  ///< size of the finding in `unit`; NaN: not applicable
  std::string unit;    ///< unit of `value`; empty: dimensionless
  Severity severity = Severity::kInfo;
  std::string sentence;  ///< whole sentence for a technician
};

/// An interval in which a torque stays at the limit of its channel.
struct SaturatedInterval {
  JointIndex joint;
  double from = 0.0;  ///< [s] time since the recording began
  double to = 0.0;
};

/// Quality of a recording by itself, without a robot.
struct RecordingQuality {
  std::string file;
  long rows = 0;
  int joints = 0;
  double duration = 0.0;  ///< [s]
  double rate = 0.0;      ///< [Hz] inverse of the median time step
  MotionPeriod period;
  RecordingFacts facts;  ///< names of the joints, topics, remarks
  std::vector<QualityFinding> findings;  ///< worst first
  std::vector<SaturatedInterval> saturated;  ///< torques exactly at a limit, while the arm moves

  /// The worst severity; kInfo without findings.
  Severity severity() const;
  /// The first finding of this kind (and of this joint, if given), or null.
  const QualityFinding* find(QualityKind kind, std::optional<JointIndex> joint = {}) const;
  /// Text: one line for the file, then one per topic, remark and finding.
  std::string report() const;
};

const char* name_of(Severity severity);

/// Checks the quality of a recording.
///
/// Memory is bounded: the checks of velocities, transient and period, and the scales of the others,
/// use the first 200,000 rows. Cost: one pass over the file, and about 1 s for that part.
/// @throws InvalidInput  as RecordingReader, or there are no rows.
RecordingQuality check_recording(const std::string& path, const RecordingOptions& options = {});

/// check_recording() for a recording in memory.
RecordingQuality check_recording(const Recording& recording);

}  // namespace veridyn
