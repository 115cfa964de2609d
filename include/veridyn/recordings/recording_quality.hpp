#pragma once

#include <string>
#include <vector>

#include "veridyn/recordings/recording.hpp"
#include "veridyn/recordings/recording_period.hpp"

namespace veridyn {

enum class Severity {
  kInfo,     ///< information; the data are used unchanged
  kWarning,  ///< the data are usable, but a result may suffer
  kFault     ///< a result from these data would be wrong
};

/// One finding of check_recording(), as plain data.
struct QualityFinding {
  std::string file;
  std::string finding;  ///< a name from the list at check_recording()
  std::string signal;   ///< "q", "dq", ...; empty: the whole file
  int joint = 0;        ///< number of the joint from 1; 0: all joints
  /// Affected share of the rows (or of the range), 0 to 1; NaN: not applicable.
  double share = 0.0;
  double value = 0.0;  ///< size of the finding in `unit`; NaN: not applicable
  std::string unit;    ///< unit of `value`; empty: dimensionless
  Severity severity = Severity::kInfo;
  std::string sentence;  ///< whole sentence for a technician
};

/// An interval in which a torque stays at the limit of its channel.
struct SaturatedInterval {
  int joint = 0;      ///< joint index from 0
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
  /// The first finding of this name (and joint, unless 0), or null.
  const QualityFinding* find(const std::string& finding, int joint = 0) const;
  /// Text: one line for the file, then one per topic, remark and finding.
  std::string report() const;
};

const char* name_of(Severity severity);

/// Checks the quality of a recording. Names of the findings, with the meaning of `value` and
/// `share`:
///
///   sample_rate         value: inverse of the median step [Hz]
///   irregular_time      value: mean rate [Hz]; steps differ by more than 5 %
///   missing_rows        steps above 1.5 median steps; share of rows lost; value: longest step [s]
///   two_rates           rows come at another rate for a while; value: that rate [Hz]
///   stale_rows          rows equal to the one before in all signals while the arm moves;
///                       value: longest run [rows]
///   stale_signal        the same for a single signal
///   gaps                NaN; share of rows; value: longest run [rows]
///   absurd_numbers      beyond +-1e6 or infinite; share of rows; value: count; gaps for all other
///                       checks
///   zero_signal         a signal is always zero
///   constant_signal     a signal never differs from its first value
///   jumps               position steps that the neighbouring motion cannot explain; value: the largest
///   saturation          torque or current stays at its extreme; value: that limit; share of rows
///   overflow            torque steps from one end of its range to the other while the joint moves on; value: that end
///   start_up_transient  torque rings when the recording starts; value: until when [s]
///   rate_contradiction  dq = value * dq/dt of q, the same value on all moving joints
///   velocity_scale      as rate_contradiction, on this joint only
///   velocity_sign       as rate_contradiction, with a value near -1
///   degrees             q or dq seems to be in degrees (dq 57.3 times too large; q beyond 4 pi most of
///                       the time)
///   velocity_quantised  dq is quantised coarsely; value: step; share: step by the signal's range
///   torque_quantised    torque or current is quantised coarsely; value: step; share: step by the signal's range
///   velocity_unrelated  dq is not the derivative of q; value: their correlation
///   velocity_delay      dq lags the derivative of q (cross-correlation); value [s]
///   joint_at_rest       q stays within 5 mrad or 5 mm; value: its range
///   same_column         the torques of two joints are equal in every row
///   no_sign             no torque of any moving joint is negative
///   no_motion           no joint moves
///   period              the motion repeats; value: the period [s]
///   remark              remark of the reader (a truncated file, repeated time stamps)
///   short_recording     too few rows for any checks except those of numbers and time
///
/// Memory is bounded: the checks of velocities, transient and period, and the scales of the others,
/// use the first 200,000 rows. Cost: one pass over the file, and about 1 s for that part.
/// @throws InvalidInput  as RecordingReader, or there are no rows.
RecordingQuality check_recording(const std::string& path, const RecordingOptions& options = {});

/// check_recording() for a recording in memory.
RecordingQuality check_recording(const Recording& recording);

}  // namespace veridyn
