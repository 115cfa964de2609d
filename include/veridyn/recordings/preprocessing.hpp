#pragma once

#include <cstdint>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "veridyn/recordings/recording_list.hpp"
#include "veridyn/recordings/stale_rows.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

class KeptRecordings;

/// Signals to which the low-pass is applied.
enum class Filtering {
  /// The torque and every column of the regressor, after the columns were built from lightly
  /// filtered signals: both sides of tau = Y phi pass the same filter, so that friction at
  /// reversals is treated alike (parallel filtering).
  kMatched,
  /// The signals q, dq, ddq and tau; the regressor is built from the filtered ones. Common in the
  /// literature, and biased where a column is not linear in the signals (sign of the velocity).
  kSignals,
};

/// Source of the velocities.
enum class VelocitySource { kRecorded, kDerived };

/// Treatment of rows that a late publisher repeated, see SoundRows.
enum class StaleRows { kFilled, kKept };

/// An interval of a recording, such as a contact or a local sticking, that is excluded from the fit and the
/// errors of one joint or of all.
struct ExcludedInterval {
  std::string source;  ///< path of the recording
  std::optional<JointIndex> joint = {};  ///< nullopt: all joints
  double from = 0.0;   ///< [s] time since the recording began
  double to = 0.0;
  std::string why;
};

/// Weights of one recording's samples in the fit of every joint, as they result from a robust loss.
struct SampleWeights {
  std::vector<double> time;  ///< [s] time since the recording began, increasing
  MatrixXd of_joint;         ///< (times x n) >= 0
  /// The weight at the first time that is not before `seconds`; one beyond the last.
  double at(JointIndex joint, double seconds) const;
};

/// Options for turning a recording into samples.
struct PreprocessingOptions {
  double cutoff = 5.0;  ///< [Hz] cut-off of the low-pass; 0: no filter
  int order = 6;        ///< order of the filter in one of its two passes
  Filtering filtering = Filtering::kMatched;
  /// [Hz] low-pass of q and dq before the columns are built, as a multiple of the cut-off (kMatched
  /// only).
  double signal_cutoff_ratio = 3.0;
  VelocitySource velocity =
      VelocitySource::kRecorded;        ///< derived from q where the recording has none
  /// Joints whose recorded velocity is replaced by the derivative of q.
  std::vector<JointIndex> derive_velocity_of;
  StaleRows stale_rows = StaleRows::kFilled;
  double rate = 0.0;  ///< [Hz] rate of the uniform grid; 0: one over the median time step
  double drop_start =
      1.2;  ///< [s] left out at the start of the file: transients of the motion and of the filter
  double drop_end = 0.5;  ///< [s] left out at the end of the file
  /// First row of the file to use; the filter sees the rows around the selection.
  long first_row = 0;
  std::optional<long> row_count = {};  ///< nullopt: to the end
  /// [rad/s] or [m/s]: rows in which a joint is slower are excluded from the fit of this joint; errors are
  /// measured on all rows.
  double min_speed = 0.0;
  /// Keeps one of this many samples after the filter; 0: as many samples as four times the cut-off needs.
  int decimation = 0;
  std::vector<ExcludedInterval> excluded_intervals;
  /// Weights by the source of a recording; samples of other recordings have weight one. Errors are measured
  /// without weights.
  std::map<std::string, std::shared_ptr<const SampleWeights>> weights;
  /// Known periods of the motion [s] by source (0: it does not repeat), which are then not detected again.
  std::map<std::string, double> known_periods;
  std::vector<std::string> columns;  ///< for files without a header, see RecordingOptions
  double header_rate = 0.0;          ///< [Hz] time base of files without t
  SignalChoice signals;              ///< topics, names and units; the joints are those of the arm
  /// Recordings in memory, by name; they take precedence over files. See Recordings.
  RecordingsInMemory in_memory;
  /// Files that were read already; the caller owns them across several calls. Null: every call
  /// reads its files.
  std::shared_ptr<KeptRecordings> kept;
  /// Polled while recordings are read; once it returns true, reading ends with Interrupted.
  std::function<bool()> interrupted;
};

/// Thrown when PreprocessingOptions::interrupted returns true.
class Interrupted : public std::exception {
 public:
  const char* what() const noexcept override { return "interrupted"; }
};

/// The arm's joints with the names under which a recording may hold them.
std::vector<WantedJoint> joints_of(const Model& arm);

/// Options for reading a recording of the arm: all rows, with the columns, rate and signals of the
/// options.
RecordingOptions recording_options_for(const Model& arm, const PreprocessingOptions& options);

/// Reads recordings of the arm into memory, each file once; joints are found by their names.
/// @throws InvalidInput  as RecordingReader, or a recording does not fit the arm.
Recordings read_recordings(const Model& arm, const std::vector<std::string>& paths,
                           const PreprocessingOptions& options = {});

/// A segment of uniform samples with positions, velocities, accelerations and torques. Matrices are
/// (rows x n), one contiguous column per joint.
struct Segment {
  double dt = 0.0;           ///< [s]
  double start = 0.0;        ///< [s] time of the recording's first sample
  VectorXd time;             ///< (rows) [s]
  MatrixXd q, dq, ddq, tau;  ///< tau is filtered with kSignals, as recorded with kMatched
  std::vector<char>
      use;  ///< (rows) 0: interpolated across a gap, dropped at an edge, or outside the selection
  Eigen::Index core_begin =
      0;  ///< rows before and after the core, in which the filter settles
  Eigen::Index core_end = 0;
  bool at_rest = false;  ///< a pose at rest: dq is the direction of approach, at the speed kRestSpeed

  /// (rows x n) velocities of the bodies.
  MatrixXd body_velocities() const { return at_rest ? MatrixXd::Zero(dq.rows(), dq.cols()) : dq; }
};

/// Properties of a recording that its preparation determines.
struct PreparationFacts {
  double dt = 0.0;
  double duration = 0.0;
  long samples = 0;  ///< number of samples on the uniform grid
  long unused = 0;   ///< number of samples in or near gaps
  long rows_read = 0;
  FilledRows filled;
  std::vector<std::uint64_t> row_hashes;  ///< hashes of some of its rows, by which copies and pieces of a recording are recognised
};

/// Reads a recording of any length once and calls `visit` for segments of a few thousand samples.
///
/// Samples are interpolated linearly on their true time; rows with NaN or with numbers above 1e6
/// are excluded, and so are samples within half a filter period of a gap: more than two steps and a
/// quarter of a wave at the cut-off. Rows that a late publisher repeated are interpolated first
/// (options.stale_rows).
///
/// @throws InvalidInput  the file is bad, or has another number of joints than the arm, or neither
/// torques nor (with drive gains in the robot file) currents.
PreparationFacts for_each_segment(const Model& arm, const std::string& path,
                                  const PreprocessingOptions& options,
                                  const std::function<void(const Segment&)>& visit);

/// for_each_segment() for a recording in memory.
PreparationFacts for_each_segment(const Model& arm, const Recording& recording,
                                  const PreprocessingOptions& options,
                                  const std::function<void(const Segment&)>& visit);

/// Number of filtered samples of which one is kept.
int decimation(const PreprocessingOptions& options, double dt);

}  // namespace veridyn
