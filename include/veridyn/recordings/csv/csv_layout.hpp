#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "veridyn/recordings/recording.hpp"

namespace veridyn {

/// Mapping from columns of a CSV file to signals and joints.
struct CsvLayout {
  static constexpr int kIgnored = -1;
  static constexpr int kTime = 0;

  char separator = ',';
  int joints = 0;
  bool has_time = false;
  std::vector<bool> has_signal;    ///< one entry per kRecordingSignals
  std::vector<int> slots;          ///< one entry per column: kIgnored, kTime, or slot(signal, joint)
  std::vector<std::string> names;  ///< names of the columns, for messages

  /// Index of a value in a row of numbers: t, then signal by signal, joint by joint (all from 0).
  int slot(int signal, int joint) const { return 1 + signal * joints + joint; }
  int slot_count() const { return slot(static_cast<int>(has_signal.size()), 0); }
};

/// Fields of a line, without blanks and quotes around them.
std::vector<std::string> csv_fields(std::string_view line, char separator);

/// The separator of a line: comma, semicolon, tab, or else blanks (' ').
char csv_separator(std::string_view line);

/// True if a field contains a word for a missing value, such as "n/a" or "null".
bool is_missing_value(std::string field);

/// Parses the number of a field, with a decimal comma unless the comma is the separator; NaN for an empty
/// field or a word for a missing value. False for other text.
bool csv_number(std::string field, char separator, double* value);

/// True if each field of the line is a number or a gap.
bool is_row_of_numbers(std::string_view line);

/// Determines the layout from a header line.
/// @param where  file and line, for messages.
/// @throws InvalidInput  no q; joints that are not numbered 1..n, or not the same n for each
/// signal; a repeated column; a missing signal whose name resembles that of a column.
CsvLayout layout_from_header(std::string_view header, const std::string& where);

/// Determines the layout of a file without a header.
/// @param columns  signals, as "t", "q", "dq", or one name for each column, as "q1", "dq1", "q2".
/// @throws InvalidInput  an unknown signal, or a number of columns that the signals cannot share.
CsvLayout layout_from_columns(const std::vector<std::string>& columns, std::string_view first_row,
                              const std::string& where);

}  // namespace veridyn
