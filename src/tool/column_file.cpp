#include "veridyn/tool/column_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include "files/words.hpp"
#include "files/input_file.hpp"
#include "veridyn/math/require.hpp"
#include "model/suggestion.hpp"

namespace veridyn::cli {
namespace {

constexpr const char* kBlank = " \t\r";

// Splits a line into fields; blanks around a field are removed, those inside it are kept.
std::vector<std::string> fields(const std::string& line) {
  std::vector<std::string> out = split(line, ',');
  for (std::string& field : out) {
    const std::size_t first = field.find_first_not_of(kBlank);
    const std::size_t last = field.find_last_not_of(kBlank);
    field = first == std::string::npos ? "" : field.substr(first, last - first + 1);
  }
  return out;
}

}  // namespace

int ColumnFile::find(const std::string& name) const {
  const auto found = std::find(names.begin(), names.end(), name);
  return found == names.end() ? -1 : static_cast<int>(found - names.begin());
}

int ColumnFile::at(const std::string& name) const {
  const int column = find(name);
  require(column >= 0, path, ":1: found no column '", name, "'", did_you_mean(name, names),
          ", expected one among: ", listed(names), ".");
  return column;
}

ColumnFile read_columns(const std::string& path, const std::string& expected) {
  std::istringstream file(content_of_file(path, expected));
  ColumnFile out;
  out.path = path;
  std::string line;
  require(static_cast<bool>(std::getline(file, line)), path, ": found nothing, expected ", expected,
          ".");
  out.names = fields(line);
  for (const std::string& name : out.names)
    require(!name.empty() && !std::isdigit(static_cast<unsigned char>(name[0])) && name[0] != '-',
            path, ":1: found '", name, "', expected a header of names: ", expected, ".");
  std::vector<double> numbers;
  long number = 1;
  while (std::getline(file, line)) {
    ++number;
    if (line.empty() || line == "\r") continue;
    const std::vector<std::string> row = fields(line);
    require(row.size() == out.names.size(), path, ":", number, ": found ", row.size(),
            " fields, expected ", out.names.size(), ".");
    for (std::size_t k = 0; k < row.size(); ++k) {
      const std::optional<double> x = number_in(row[k]);
      require(x && std::isfinite(*x), path, ":", number, ": found '",
              row[k], "' in column ", out.names[k], ", expected a finite number.");
      numbers.push_back(*x);
    }
  }
  require(!numbers.empty(), path, ": found no rows, expected at least one.");
  const auto columns = static_cast<Eigen::Index>(out.names.size());
  const auto rows = static_cast<Eigen::Index>(numbers.size()) / columns;
  out.values = Eigen::Map<Eigen::Matrix<double, -1, -1, Eigen::RowMajor>>(numbers.data(), rows, columns);
  return out;
}

}  // namespace veridyn::cli
