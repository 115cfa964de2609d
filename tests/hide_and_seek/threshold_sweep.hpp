#pragma once

#include <string>
#include <vector>

#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn::seek {

/// Sets a number that decides. @param setting  "NAME=VALUE".
/// @throws InvalidInput  there is no threshold of this name, or the value is no number.
void set_threshold(const std::string& setting, DiagnosisOptions& options);

/// Every number that decides, with its inequality and reason, as a Markdown table.
/// @param sweeps  file of write_sweeps(): a column shows what each factor changed; empty: none.
void print_thresholds(const std::string& sweeps = {});

/// The numbers of a room with what each factor changed; the header of its numbers has their inequalities.
void print_numbers(const std::string& room, const std::string& sweeps);

/// Rooms other than diagnose: "check", "watch", "compare", "fleet".
const std::vector<std::string>& swept_rooms();

struct SweepRequest {
  std::string room = "diagnose";     ///< or one of swept_rooms()
  std::vector<std::string> numbers;  ///< of the room; empty: those without a sweep of their value
  std::vector<double> factors = {0.5, 0.7, 1.4, 2.0};
  unsigned seed = 811;
  std::string file;
  DiagnosisOptions options;
};

/// Asks the cases of the room's small board that concern it with every number at its value and multiplied by
/// each factor, and writes a row of CSV for each into the file, in place of earlier rows of the same numbers. A case that
/// the smallest and the largest factor leave as it is, is not asked between them.
void write_sweeps(const SweepRequest& request);

}  // namespace veridyn::seek
