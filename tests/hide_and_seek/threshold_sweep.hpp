#pragma once

#include <string>
#include <vector>

#include "hide_and_seek/board.hpp"

namespace veridyn::seek {

/// Sets a number that decides. @param setting  "NAME=VALUE".
/// @throws InvalidInput  there is no threshold of this name, or the value is no number.
void set_threshold(const std::string& setting, DiagnosisOptions& options);

/// Every number that decides, with its inequality and reason, as a Markdown table.
/// @param sweeps  file of write_sweeps(): a column shows what each factor changed; empty: none.
void print_thresholds(const std::string& sweeps = {});

/// Plays a board with one threshold multiplied by each of the factors, and prints how many causes
/// are named and how many names are false.
void print_sweep(const BoardRequest& request, const std::string& name,
                 const std::vector<double>& factors);

/// Plays a board and causes on no list with every number at its value and multiplied by each factor, and
/// writes a row of CSV for each into `file`, in place of earlier rows of the same numbers.
void write_sweeps(const BoardRequest& request, const std::vector<std::string>& names,
                  const std::vector<double>& factors, const std::string& file);

}  // namespace veridyn::seek
