#pragma once

#include <string>
#include <vector>

#include "veridyn/math/types.hpp"

namespace veridyn::cli {

/// A small CSV file with a header of names and rows of numbers.
struct ColumnFile {
  std::string path;
  std::vector<std::string> names;
  MatrixXd values;  ///< (rows x names)

  /// Index of the column with this name; -1 if there is none.
  int find(const std::string& name) const;
  /// Index of the column. @throws InvalidInput  there is none; with file, line, names found and expected.
  int at(const std::string& name) const;
};

/// @throws InvalidInput  no such file, no header, a field that is no finite number, a row of
/// another length, no rows.
ColumnFile read_columns(const std::string& path, const std::string& expected);

}  // namespace veridyn::cli
