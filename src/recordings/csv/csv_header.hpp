#pragma once

#include <optional>
#include <string>
#include <vector>

#include "recordings/csv/csv_lines.hpp"
#include "recordings/csv/time_column.hpp"
#include "veridyn/recordings/recording.hpp"

namespace veridyn::recordings {

/// The header of a table with arbitrary column names.
struct CsvHeader {
  char separator = ',';
  std::vector<std::string> names;
  std::vector<std::string> units;  ///< units of a second line, or empty
  TimeColumns time;
  int positions = 0;      ///< columns that are positions of joints
  long line = 0;          ///< number of its line in the file
  std::string first_row;  ///< first line of numbers, if it was read in advance
};

/// Finds the header among the first lines: it has a clock or positions of joints. The last comment before the
/// numbers may be the header; other lines may precede it.
std::optional<CsvHeader> find_csv_header(CsvLines& lines, const RecordingOptions& options);

/// True for a header t, q1..qn, which is read row by row by csv_rows().
bool is_plain(const CsvHeader& header);

/// Topic and path of a column: "/joint_states/elbow/position" is elbow/position on /joint_states,
/// "/arm/effort/data[0]" is data[0] on /arm/effort; other names have no topic.
struct TopicColumn {
  std::string topic, path;
};
TopicColumn split_topic(const std::string& name);

/// A column name of rostopic echo -p without the prefix `field.`.
std::string plain_name(const std::string& name);

/// A unit of a header without brackets and signs, spelt as unit_factor() expects.
std::string bare_unit(std::string unit);

/// The column that --map takes as the time; empty: none.
std::string time_name(const RecordingOptions& options);

}  // namespace veridyn::recordings
