#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "recordings/csv/time_column.hpp"

namespace veridyn::recordings {

/// The header of a table with arbitrary column names.
struct CsvHeader {
  char separator = ',';
  std::vector<std::string> names;
  std::vector<std::string> units;  ///< of a second line, or empty
  TimeColumns time;
  int positions = 0;  ///< columns that are positions of joints
};

/// @param time_name  the column of the clock chosen by the user; else empty.
CsvHeader parse_csv_header(std::string_view line, const std::string& time_name);

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

/// True if a field of a second line may be a unit; bare_unit() removes brackets and signs.
bool is_unit_word(const std::string& word);
std::string bare_unit(std::string unit);

}  // namespace veridyn::recordings
