#include "veridyn/recordings/recording.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "recordings/remark.hpp"
#include "files/output_file.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr int kPieceRows = 1 << 16;

void append_number(double value, int digits, std::string* line) {
  if (std::isnan(value)) return;
  char digits_text[32];
  const auto [end, error] = std::to_chars(digits_text, digits_text + sizeof digits_text, value,
                                          std::chars_format::general, digits);
  line->append(digits_text, end);
}

std::string csv_header_of(const Recording& recording) {
  std::string line = "t";
  for (const RecordingSignal& signal : kRecordingSignals) {
    for (int joint = 1; joint <= (recording.*signal.values).cols(); ++joint)
      line += text(",", signal.name, joint);
  }
  return line + "\n";
}

}  // namespace

Recording rows_of(const Recording& recording, int first, int count) {
  Recording part;
  part.source = recording.source;
  part.poses = recording.poses;
  part.time = recording.time.segment(first, count);
  for (const RecordingSignal& signal : kRecordingSignals) {
    const MatrixXd& values = recording.*signal.values;
    if (values.cols() > 0) part.*signal.values = values.middleRows(first, count);
  }
  return part;
}

void append(Recording& recording, Recording more) {
  if (recording.rows() == 0) {
    recording = std::move(more);
    return;
  }
  const int rows = recording.rows();
  recording.time.conservativeResize(rows + more.rows());
  recording.time.tail(more.rows()) = more.time;
  for (const RecordingSignal& signal : kRecordingSignals) {
    MatrixXd& m = recording.*signal.values;
    if (m.cols() == 0) continue;
    m.conservativeResize(rows + more.rows(), Eigen::NoChange);
    m.bottomRows(more.rows()) = more.*signal.values;
  }
}

Recording read_recording(const std::string& path, const RecordingOptions& options,
                         RecordingFacts& facts) {
  RecordingReader reader(path, options);
  std::vector<Recording> pieces;
  Eigen::Index rows = 0;
  do {
    pieces.push_back(reader.next(kPieceRows));
    rows += pieces.back().rows();
  } while (pieces.back().rows() == kPieceRows);
  facts = reader.facts();
  if (rows == 0 && (options.first_row > 0 || options.row_count == 0)) {
    throw InvalidInput(
        text(path, ": found no row from row ", options.first_row, " on, expected some in --rows."));
  }
  require(rows > 0, path, ": found a header without rows, expected numbers below it.");
  if (pieces.size() == 1) return std::move(pieces.front());

  Recording whole;
  whole.source = path;
  whole.time.resize(rows);
  for (const RecordingSignal& signal : kRecordingSignals) {
    if ((pieces.front().*signal.values).cols() > 0)
      (whole.*signal.values).resize(rows, reader.joints());
  }
  Eigen::Index row = 0;
  for (Recording& piece : pieces) {
    whole.time.segment(row, piece.rows()) = piece.time;
    for (const RecordingSignal& signal : kRecordingSignals) {
      if ((whole.*signal.values).cols() > 0)
        (whole.*signal.values).middleRows(row, piece.rows()) = piece.*signal.values;
    }
    row += piece.rows();
    piece = Recording();
  }
  return whole;
}

Recording read_recording(const std::string& path, const RecordingOptions& options) {
  RecordingFacts facts;
  return read_recording(path, options, facts);
}

void write_recording(const Recording& recording, const std::string& path) {
  write_recording(recording, path, "");
}

void write_recording(const Recording& recording, const std::string& path,
                     const std::string& remark) {
  for (const RecordingSignal& signal : kRecordingSignals) {
    const MatrixXd& values = recording.*signal.values;
    require(values.cols() == 0 ||
                (values.rows() == recording.rows() && values.cols() == recording.joints()),
            "write_recording: ", signal.name, " is ", values.rows(), " x ", values.cols(),
            ", but time has ", recording.rows(), " rows and q has ", recording.joints(),
            " joints.");
  }
  OutputFile file(path);
  std::string line = (remark.empty() ? "" : "# " + remark + "\n") + csv_header_of(recording);
  for (int row = 0; row < recording.rows(); ++row) {
    append_number(recording.time[row], 15, &line);
    for (const RecordingSignal& signal : kRecordingSignals) {
      const MatrixXd& values = recording.*signal.values;
      for (int joint = 0; joint < values.cols(); ++joint) {
        line += ',';
        append_number(values(row, joint), 10, &line);
      }
    }
    line += '\n';
    file.stream().write(line.data(), static_cast<std::streamsize>(line.size()));
    line.clear();
  }
  if (recording.rows() == 0) file.stream() << line;
  file.commit();
}

}  // namespace veridyn
