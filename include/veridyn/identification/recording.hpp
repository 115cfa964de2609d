#pragma once

#include <string>
#include <vector>

#include "veridyn/math/types.hpp"

namespace veridyn {

/// Signals of one arm against time, structure of arrays: one contiguous column per joint.
///
/// Matrices are (rows x joints), or (0 x 0) where the recording has no such signal. NaN marks a gap.
struct Recording {
  std::string source;  ///< file name, for messages
  VectorXd time;       ///< (rows) [s], strictly increasing
  MatrixXd q;          ///< [rad], [m] where the joint is prismatic
  MatrixXd dq;         ///< [rad/s], [m/s]
  MatrixXd ddq;        ///< [rad/s^2], [m/s^2]
  MatrixXd tau;        ///< [N m], [N]
  MatrixXd current;    ///< motor currents [A]

  int rows() const { return static_cast<int>(time.size()); }
  int joints() const { return static_cast<int>(q.cols()); }
};

/// How a file is to be read.
struct RecordingOptions {
  /// Signals in the order of the columns of a file without a header, e.g. {"q", "dq", "tau"}, each with
  /// the same number of joints; empty: the file has a header. "t" is allowed as the first.
  std::vector<std::string> columns;
  double rate = 0.0;    ///< [Hz] time base of a file without a column t; 0: there must be one
  long first_row = 0;   ///< the first row to keep, counting from 0
  long row_count = -1;  ///< rows to keep; -1: all
};

/// Reads a recording in pieces, so that its length costs no memory.
///
/// CSV with a header `t,q1..qn,dq1..dqn,tau1..taun` (also `ddq1..`, `i1..`); other columns are ignored;
/// an empty field and `nan` are gaps. Lines that start with `#` and empty lines are skipped.
class RecordingReader {
 public:
  /// @throws InvalidInput  the file cannot be opened, or its header makes no sense.
  RecordingReader(const std::string& path, const RecordingOptions& options);
  ~RecordingReader();
  RecordingReader(const RecordingReader&) = delete;
  RecordingReader& operator=(const RecordingReader&) = delete;

  /// The next rows, at most `rows` of them; empty at the end.
  /// @throws InvalidInput  ragged rows, text in a number, time that stands still or runs back; the message
  ///                       names file, line and column.
  Recording next(int rows);

  int joints() const;

 private:
  struct State;
  State* state_;
};

/// The whole recording in memory. @throws InvalidInput as RecordingReader does, or no rows at all.
Recording read_recording(const std::string& path, const RecordingOptions& options = {});

/// Writes CSV with a header as CONTRACT describes it; whole or not at all.
void write_recording(const Recording& recording, const std::string& path);

}  // namespace veridyn
