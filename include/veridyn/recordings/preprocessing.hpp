#pragma once

#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "veridyn/recordings/recording_list.hpp"
#include "veridyn/recordings/stale_rows.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

class KeptRecordings;

/// What is low-pass filtered.
enum class Filtering {
  /// The torque and every column of the regressor, after the columns were built from lightly
  /// filtered signals:
  /// both sides of tau = Y phi go through one filter, so that friction at reversals is treated
  /// alike.
  kMatched,
  /// The signals q, dq, ddq and tau; the regressor is built from the filtered ones. As most of the
  /// literature does it, and
  /// biased where a column is not linear in the signals (sign of the velocity).
  kSignals,
};

/// Where velocities come from.
enum class VelocitySource { kRecorded, kDerived };

/// What becomes of rows that a late publisher wrote twice, see SoundRows.
enum class StaleRows { kFilled, kKept };

/// Part of a recording that a joint's rows leave out, of the fit and of the errors: a contact, a
/// snag.
struct LeftOut {
  std::string source;  ///< Path of the recording
  int joint = -1;      ///< from 0; -1: all joints
  double from = 0.0;   ///< [s] since the recording began
  double to = 0.0;
  std::string why;
};

/// From a recording to samples.
struct PreprocessingOptions {
  double cutoff = 5.0;  ///< [Hz] of the low-pass; 0: no filter
  int order = 6;        ///< Order of one of its two passes
  Filtering filtering = Filtering::kMatched;
  /// [Hz] low-pass of q and dq before the columns are built, as a multiple of the cut-off (kMatched
  /// only).
  double signal_cutoff_ratio = 3.0;
  VelocitySource velocity =
      VelocitySource::kRecorded;        ///< derived from q where the recording has none
  std::vector<int> derive_velocity_of;  ///< joints from 0 whose recorded velocity is not to be used
  StaleRows stale_rows = StaleRows::kFilled;
  double rate = 0.0;  ///< [Hz] of the uniform grid; 0: one over the median time step
  double drop_start =
      1.2;  ///< [s] left out at the start of the file: transients of the motion and of the filter
  double drop_end = 0.5;  ///< [s] left out at its end
  long first_row = 0;     ///< rows of the file to use; the filter sees what lies around them
  long row_count = -1;    ///< -1: to the end
  /// [rad/s] or [m/s]: rows of a joint that moves slower are left out of the fit (errors are still
  /// measured on all).
  double min_speed = 0.0;
  /// Keep one sample in so many after the filter; 0: as many as four times the cut-off needs.
  int decimation = 0;
  std::vector<LeftOut> left_out;
  /// [s] by source: periods of the motion that are known already (0: it does not repeat) and need
  /// not be detected again.
  std::map<std::string, double> known_periods;
  std::vector<std::string> columns;  ///< for files without a header, see RecordingOptions
  double header_rate = 0.0;          ///< [Hz] time base of files without t
  SignalChoice signals;              ///< topics, names and units; joints are those of the arm
  /// Recordings that are not read from files: a name found here is one of these. See Recordings.
  RecordingsInMemory in_memory;
  /// Files that were read already: whoever asks many questions of them owns it. Nothing: every file
  /// is read anew whenever it is asked for.
  std::shared_ptr<KeptRecordings> kept;
  /// Asked now and then while recordings are read; once true, what asked for them ends with
  /// Interrupted.
  std::function<bool()> interrupted;
};

/// What PreprocessingOptions::interrupted brings about.
class Interrupted : public std::exception {
 public:
  const char* what() const noexcept override { return "interrupted"; }
};

/// The arm's joints, as they are looked for in a recording.
std::vector<WantedJoint> joints_of(const Model& arm);

/// How to read a recording of the arm: all rows, with the columns, rate and signals of the options.
RecordingOptions reading_of(const Model& arm, const PreprocessingOptions& options);

/// A stretch of uniform samples, ready for the equations of motion. Matrices are (rows x n), one
/// contiguous column a joint.
struct Stretch {
  double dt = 0.0;           ///< [s]
  double start = 0.0;        ///< [s] time of the recording's first sample
  VectorXd time;             ///< (rows) [s]
  MatrixXd q, dq, ddq, tau;  ///< tau is filtered in kSignals, as recorded in kMatched
  std::vector<char>
      use;  ///< (rows) 0: interpolated across a gap, dropped at an edge, or outside the rows wanted
  Eigen::Index core_begin =
      0;  ///< rows before and after the core are only there for the filter to settle
  Eigen::Index core_end = 0;
};

/// Facts about a recording that preparing it brings to light.
struct PreparationFacts {
  double dt = 0.0;
  double duration = 0.0;
  long samples = 0;  ///< on the uniform grid
  long unused = 0;   ///< Rows of these in or near gaps
  long rows_read = 0;
  FilledRows filled;
};

/// Reads a recording once, in stretches of a few thousand samples, whatever its length; calls
/// `visit` for each.
///
/// Samples are interpolated linearly on their true time; rows with NaN or with numbers above 1e6
/// are left out, and what lies within half a filter period of a gap of more than two steps is not
/// used. Before all this rows that a late publisher wrote twice are filled in (options.stale_rows).
///
/// @throws InvalidInput  the file is bad, or has another number of joints than the arm, or neither
/// torques nor
///                       (with drive gains in the robot file) currents.
PreparationFacts for_each_stretch(const Model& arm, const std::string& path,
                                  const PreprocessingOptions& options,
                                  const std::function<void(const Stretch&)>& visit);

/// The same for a recording in memory.
PreparationFacts for_each_stretch(const Model& arm, const Recording& recording,
                                  const PreprocessingOptions& options,
                                  const std::function<void(const Stretch&)>& visit);

/// Samples kept after the filter, one in this many.
int decimation(const PreprocessingOptions& options, double dt);

}  // namespace veridyn
