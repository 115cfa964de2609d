#pragma once

#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace veridyn {

/// Recordings and messages that other people's writers made (see samples/README.md).
inline std::string sample(const std::string& name) {
  return VERIDYN_SOURCE_DIR "/tests/recordings/samples/" + name;
}

inline std::string bytes_of_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream out;
  out << file.rdbuf();
  return out.str();
}

/// One row of truth.csv: joints in the order elbow, shoulder lift, shoulder pan.
struct TrueRow {
  double stamp = 0.0;  ///< [s] since the first
  double position[3], velocity[3], effort[3];
};

inline std::vector<TrueRow> true_rows() {
  std::ifstream file(sample("truth.csv"));
  std::string line;
  std::getline(file, line);
  std::vector<TrueRow> rows;
  while (std::getline(file, line)) {
    std::istringstream fields(line);
    std::vector<std::string> cells;
    for (std::string cell; std::getline(fields, cell, ',');) cells.push_back(cell);
    TrueRow row;
    row.stamp = static_cast<double>(std::stoll(cells[1]) - 1700000000000000000LL) * 1e-9;
    for (std::size_t k = 0; k < 3; ++k) {
      row.position[k] = std::stod(cells[3 + k]);
      row.velocity[k] = std::stod(cells[6 + k]);
      row.effort[k] = std::stod(cells[9 + k]);
    }
    rows.push_back(row);
  }
  return rows;
}

}  // namespace veridyn
