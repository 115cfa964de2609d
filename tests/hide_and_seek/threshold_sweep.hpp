#pragma once

#include <string>
#include <vector>

#include "hide_and_seek/board.hpp"

namespace veridyn::seek {

/// Sets a number that decides. @param setting  "NAME=VALUE".
/// @throws InvalidInput  there is no threshold of this name, or the value is no number.
void set_threshold(const std::string& setting, DiagnosisOptions& options);

/// Every number that decides, with its inequality and reason, as a Markdown table.
void print_thresholds();

/// Plays a board with one threshold multiplied by each of the factors, and prints how many causes
/// are named and how many names are false.
void print_sweep(const BoardRequest& request, const std::string& name,
                 const std::vector<double>& factors);

}  // namespace veridyn::seek
