#include "capture_formats.hpp"

#include <algorithm>
#include <cstdlib>

#include "veridyn/recordings/csv/csv_layout.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::internal {
namespace {

using Fields = std::vector<std::string>;
using Kind = CaptureColumn::Kind;

// "file:line" of the last line read.
std::string where(const CsvLines& lines) {
  return text(lines.path(), ":", lines.number());
}

// Fields of the next line; throws InvalidInput at the end of the file.
Fields next_fields(CsvLines& lines, char separator, const char* expected) {
  std::string_view line;
  require(lines.next(&line), lines.path(), ": found the end of the file, expected ", expected, ".");
  return csv_fields(line, separator);
}

bool begins_with(const std::string& word, const std::string& start) {
  return word.compare(0, start.size(), start) == 0;
}

// The field after `key`; empty if there is none.
std::string value_after(const Fields& fields, const std::string& key) {
  const auto found = std::find(fields.begin(), fields.end(), key);
  return found == fields.end() || found + 1 == fields.end() ? "" : *(found + 1);
}

// BODY:MARKER as BODY/MARKER.
std::string with_slash(std::string name) {
  std::replace(name.begin(), name.end(), ':', '/');
  return name;
}

// Column of component `index` (CaptureColumn) of an object, called `name` in messages.
CaptureColumn component_column(const std::string& object, int index, const std::string& name) {
  CaptureColumn column;
  column.kind = Kind::kComponent;
  column.object = object;
  column.index = index;
  column.name = object + " " + name;
  return column;
}

// Motive: keys and values; then rows Type, Name, ID (and Parent); then Position or Rotation; then
// Frame, Time (Seconds), X, Y, Z (, W).
CaptureHeader motive_header(CsvLines& lines, const Fields& first) {
  CaptureHeader header;
  header.padded = true;
  header.unit = value_after(first, "Length Units");
  header.rate = std::atof(value_after(first, "Export Frame Rate").c_str());
  Fields types;
  Fields names;
  Fields parts;
  for (;;) {
    const Fields row = next_fields(lines, ',', "a row 'Frame,Time (Seconds),X,...'");
    const std::string key = row.size() > 1 ? row[1] : "";
    if (key == "Type") types = row;
    if (key == "Name") names = row;
    if (row.size() > 2 && (row[2] == "Rotation" || row[2] == "Position")) parts = row;
    if (row[0] != "Frame") continue;
    require(!names.empty() && names.size() >= row.size() && parts.size() >= row.size(),
            where(lines), ": found no names of markers above, expected rows Name and Position.");
    for (std::size_t k = 0; k < row.size(); ++k) {
      if (k < 2) {
        CaptureColumn column;
        column.kind = k == 1 ? Kind::kTime : Kind::kIgnored;
        column.name = row[k];
        header.columns.push_back(column);
        continue;
      }
      static const std::string kAxes = "XYZ";
      const bool quaternion = parts[k] == "Rotation";
      const std::size_t axis = kAxes.find(row[k]);
      const bool error = parts[k] != "Position" && !quaternion;
      if (error || (axis == std::string::npos && row[k] != "W")) {
        header.columns.emplace_back();
        continue;
      }
      const int at = static_cast<int>(axis);
      // The markers of a body have more information than the pose that the program fitted to them.
      header.columns.push_back(component_column(with_slash(names[k]),
                                         !quaternion               ? at
                                         : row[k] == "W"           ? 3
                                                                   : 4 + at,
                                         row[k]));
    }
    return header;
  }
}

// Nexus: "Trajectories", the rate, names over the first of three columns, Frame, Sub Frame, X, Y,
// Z, and units.
CaptureHeader nexus_header(CsvLines& lines) {
  CaptureHeader header;
  header.padded = true;
  header.rate = std::atof(next_fields(lines, ',', "the rate")[0].c_str());
  const Fields names = next_fields(lines, ',', "names of markers");
  const Fields axes = next_fields(lines, ',', "a row 'Frame,Sub Frame,X,Y,Z,...'");
  const Fields units = next_fields(lines, ',', "a row of units");
  std::string object;
  for (std::size_t k = 0; k < axes.size(); ++k) {
    static const std::string kAxes = "XYZ";
    if (k < names.size() && !names[k].empty()) object = with_slash(names[k]);
    const std::size_t axis = kAxes.find(axes[k]);
    if (axes[k].size() != 1 || axis == std::string::npos) {
      header.columns.emplace_back();
      continue;
    }
    header.columns.push_back(component_column(object, static_cast<int>(axis), axes[k]));
    if (k < units.size()) header.columns.back().unit = units[k];
  }
  return header;
}

// Track Manager: keys and values up to MARKER_NAMES, perhaps a row of column names, then x, y, z of
// every marker in millimetres.
CaptureHeader track_manager_header(CsvLines& lines) {
  CaptureHeader header;
  header.separator = '\t';
  header.padded = true;
  header.unit = "mm";
  for (;;) {
    const Fields row = next_fields(lines, '\t', "a row MARKER_NAMES");
    if (row[0] == "FREQUENCY" && row.size() > 1) header.rate = std::atof(row[1].c_str());
    if (row[0] != "MARKER_NAMES") continue;
    for (std::size_t k = 1; k < row.size(); ++k) {
      if (row[k].empty()) continue;
      std::string object = parsed_column(row[k] + "/x").object;
      for (int c = 0; c < 3; ++c)
        header.columns.push_back(component_column(object, c, std::string(1, "XYZ"[c])));
    }
    return header;
  }
}

// Unit that a comment states: "unit: mm", or "units in mm" among other words; empty: none.
std::string unit_in_comment(const std::string& comment) {
  std::string words;
  for (const char c : comment) words += c == ':' || c == '=' ? " : " : std::string(1, c);
  const Fields fields = csv_fields(words, ' ');
  const auto unit = std::find_if(fields.begin(), fields.end(), [](const std::string& word) {
    return begins_with(word, "unit") || begins_with(word, "Unit");
  });
  if (unit == fields.end()) return "";
  if (std::distance(unit, fields.end()) > 2 && unit[1] == ":") return unit[2];
  const auto known = std::find_if(unit, fields.end(), [](const std::string& word) { return metres_of(word) > 0.0; });
  return known == fields.end() ? "" : *known;
}

}  // namespace

CaptureHeader read_capture_header(CsvLines& lines) {
  std::string_view line;
  require(lines.next(&line), lines.path(), ": found no row, expected a header with t, x, y, z.");
  const char separator = csv_separator(line);
  const Fields names = csv_fields(line, separator);
  require(!names.empty(), where(lines), ": found no name, expected a header with t, x, y, z.");
  if (names[0] == "Format Version") return motive_header(lines, names);
  if (names[0] == "Trajectories") return nexus_header(lines);
  if (begins_with(names[0], "NO_OF_FRAMES")) return track_manager_header(lines);
  CaptureHeader header;
  header.separator = separator;
  header.unit = unit_in_comment(lines.last_comment());
  for (const std::string& name : names) header.columns.push_back(parsed_column(name));
  return header;
}

}  // namespace veridyn::internal
