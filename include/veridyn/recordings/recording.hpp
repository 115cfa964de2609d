// recordings/: CSV, bags and arrays as signals of one arm; their quality and preprocessing.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "veridyn/math/types.hpp"
#include "veridyn/recordings/recording_facts.hpp"
#include "veridyn/recordings/signal_choice.hpp"

namespace veridyn {

namespace recordings {
class RowSource;
}

/// Signals of one arm against time, structure of arrays: one contiguous column per joint.
///
/// Matrices are (rows x joints), or (0 x 0) where the recording has no such signal. NaN marks a
/// gap.
struct Recording {
  std::string source;  ///< file name, for messages
  VectorXd time;       ///< (rows) [s], finite and strictly increasing
  MatrixXd q;          ///< [rad], [m] where the joint is prismatic
  MatrixXd dq;         ///< [rad/s], [m/s]
  MatrixXd ddq;        ///< [rad/s^2], [m/s^2]
  MatrixXd tau;        ///< [N m], [N]
  MatrixXd current;    ///< motor currents [A]
  /// True if every row is a pose at rest, in any order: dq is then the direction (-1, 0, 1) from which a joint came to
  /// rest, and rows are not filtered, differentiated or dropped.
  bool poses = false;

  int rows() const { return static_cast<int>(time.size()); }
  int joints() const { return static_cast<int>(q.cols()); }
};

/// A signal of a recording: its name in files and its member.
struct RecordingSignal {
  const char* name;
  MatrixXd Recording::*values;
};

/// All signals of a file, in the order in which they are written.
inline constexpr RecordingSignal kRecordingSignals[] = {{"q", &Recording::q},
                                                        {"dq", &Recording::dq},
                                                        {"ddq", &Recording::ddq},
                                                        {"tau", &Recording::tau},
                                                        {"i", &Recording::current}};

/// Rows first .. first + count - 1 of every signal.
Recording rows_of(const Recording& recording, int first, int count);

/// Appends rows with the same signals.
void append(Recording& recording, Recording more);

/// Options for reading a file.
struct RecordingOptions {
  /// Signals in the order of the columns, e.g. {"q", "dq", "tau"}, each with the same number of joints; "t"
  /// may come first. A header is then ignored. Empty: the header determines them.
  std::vector<std::string> columns;
  double rate = 0.0;  ///< [Hz] time base of a file without a column t, ignored if it has one
  long first_row =
      0;  ///< first row to keep, from 0; rows before it are not parsed
  std::optional<long> row_count = {};  ///< rows to keep; nullopt: all
  SignalChoice signals;  ///< topics, names of columns and joints, units
};

/// Reads a recording in pieces; a plain CSV of any length needs little memory.
///
/// Besides CSV of the form below: ROS 1 bags, ROS 2 bags (sqlite3, MCAP; files and folders), MCAP,
/// CSV with other headers, .npz, .mat and HDF5, see docs/recordings.md; these are kept in memory.
///
/// CSV with a header `t,q1..qn,dq1..dqn,tau1..taun` (also `ddq1..`, `i1..`) in any order; only q is required;
/// other columns are ignored. The separator is a comma, a semicolon, a tab or blanks, as found in the first
/// line. An empty field and `nan` are gaps; a row without any number, even for t, is a gap row, and its time
/// is interpolated (it is dropped at either end of the file). Lines that start with `#` and empty lines are
/// skipped, except that the last `#` line before the numbers may be the header. Infinite and absurd numbers
/// are kept as values: check_recording() reports them. A row with the time of the previous one is dropped and
/// counted in facts(). A decimal comma is accepted if the separator is another character.
/// Cost: one pass, about 30 ns a number (400 MB/s); 1 MiB of buffer.
class RecordingReader {
 public:
  /// @throws InvalidInput  the file cannot be opened or is empty, has no header and options.columns
  /// is empty, or the header is not understood.
  explicit RecordingReader(const std::string& path, const RecordingOptions& options = {});
  ~RecordingReader();
  RecordingReader(RecordingReader&&) noexcept;
  RecordingReader& operator=(RecordingReader&&) noexcept;

  /// The next rows, at most `rows` of them; empty at the end.
  /// @throws InvalidInput  ragged rows, text in a number, time that is missing or decreases; the
  /// message names file, line and column (the field's number, from 1).
  Recording next(int rows);

  int joints() const;

  /// Names of the joints, topics and remarks; remarks on rows are complete at the end of the file.
  RecordingFacts facts() const;

 private:
  std::unique_ptr<recordings::RowSource> source_;
};

/// The whole recording in memory.
/// @throws InvalidInput  as RecordingReader, or the selection holds no row.
Recording read_recording(const std::string& path, const RecordingOptions& options = {});

/// Also sets `facts`: names of the joints, topics, remarks.
Recording read_recording(const std::string& path, const RecordingOptions& options,
                         RecordingFacts& facts);

/// Writes CSV with a header, atomically: t with 15 significant digits, signals with 10, NaN as an
/// empty field. read_recording() returns the same up to that rounding.
/// @throws InvalidInput  signals of unequal size, or a file that cannot be written.
void write_recording(const Recording& recording, const std::string& path);

}  // namespace veridyn
