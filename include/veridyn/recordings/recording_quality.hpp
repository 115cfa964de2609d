#pragma once

#include <string>
#include <vector>

#include "veridyn/recordings/recording.hpp"
#include "veridyn/recordings/recording_period.hpp"

namespace veridyn {

enum class Severity {
  kInfo,     ///< good to know; the data are used as they are
  kWarning,  ///< the data are usable, but a result may suffer
  kFault     ///< a result from these data would be wrong
};

/// One thing that a recording shows, as plain data.
struct QualityFinding {
  std::string file;
  std::string finding;  ///< a name of the list at check_recording()
  std::string signal;   ///< "q", "dq", ...; empty: the whole file
  int joint = 0;        ///< from 1; 0: all joints
  double share = 0.0;  ///< share of the rows (or of the range) that is concerned, 0 to 1; NaN: none
  double value = 0.0;  ///< size of the finding in `unit`; NaN: none
  std::string unit;    ///< Unit of `value`; empty: a plain number
  Severity severity = Severity::kInfo;
  std::string sentence;  ///< for a technician
};

/// What a recording alone tells, without a robot.
struct RecordingQuality {
  std::string file;
  long rows = 0;
  int joints = 0;
  double duration = 0.0;  ///< [s]
  double rate = 0.0;      ///< [Hz] one over the median time step
  MotionPeriod period;
  RecordingFacts facts;  ///< joints' names, topics, remarks
  std::vector<QualityFinding> findings;  ///< worst first

  /// The worst severity; kInfo if there is nothing.
  Severity severity() const;
  /// The first finding of this name (and joint, unless 0), or null.
  const QualityFinding* find(const std::string& finding, int joint = 0) const;
  /// One line for the file, one per topic, remark and finding.
  std::string report() const;
};

const char* name_of(Severity severity);

/// Quality of a recording. Names of findings, with what `value` and `share` are:
///
///   sample_rate         value: one over the median step [Hz]
///   irregular_time      value: mean rate [Hz]; steps differ by more than 5 %
///   missing_rows        steps above 1.5 median steps; share of rows lost; value: longest step [s]
///   stale_rows          rows equal to the one before in all signals while the arm moves;
///                       value: longest run [rows]
///   stale_signal        the same for one signal alone
///   gaps                NaN; share of rows; value: longest run [rows]
///   absurd_numbers      beyond +-1e6 or infinite; share of rows; value: count; gaps for all other
///                       checks
///   zero_signal         a signal is always zero
///   constant_signal     a signal never differs from its first value
///   jumps               position steps that the motion around cannot explain; value: the largest
///   saturation          torque or current sits at its extreme; value: that limit; share of rows
///   start_up_transient  torque rings when the recording starts; value: until when [s]
///   rate_contradiction  dq = value * dq/dt of q, the same value on all moving joints
///   velocity_scale      the same, on this joint only
///   velocity_sign       the same with value near -1
///   degrees             q or dq looks like degrees (dq 57.3 times too large; q beyond 4 pi most of
///                       the time)
///   velocity_quantised  dq goes in coarse steps; value: step; share: step by the signal's range
///   velocity_delay      dq comes later than the derivative of q (cross-correlation); value [s]
///   joint_at_rest       q stays within 5 mrad or 5 mm; value: its range
///   no_motion           no joint moves
///   period              the motion repeats; value: the period [s]
///   remark              what reading the file brought up (a cut file, repeated time stamps)
///   short_recording     too few rows to judge more than numbers and time
///
/// Streams: memory is bounded by the first 200,000 rows, on which velocities, transient, period and
/// the scales of the other checks are judged. Cost: one pass over the file, and about 1 s for that
/// part.
/// @throws InvalidInput  as RecordingReader does, or there are no rows.
RecordingQuality check_recording(const std::string& path, const RecordingOptions& options = {});

/// The same for a recording in memory.
RecordingQuality check_recording(const Recording& recording);

}  // namespace veridyn
