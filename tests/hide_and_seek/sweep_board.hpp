#pragma once

#include <functional>
#include <string>
#include <vector>

#include "hide_and_seek/swept_room.hpp"

namespace veridyn::seek {

/// A case whose recordings are written and, where it starts from a MODEL, whose arm is identified.
struct SweepCase {
  std::string name;
  std::string about;  ///< questions that it asks: "contact", "constant change", ...
  std::function<SweepAnswer(const DiagnosisOptions&)> ask;
};

/// The small board on which the numbers of the diagnosis are swept: a few cases for each question that it
/// asks, on a SCARA and the first axes of a PSM, a second each or less.
/// @param folder  of the recordings; it stays as long as the cases are asked.
std::vector<SweepCase> sweep_board(unsigned seed, const std::string& folder);

/// True if a case asks the question that a number belongs to, or has nothing hidden.
bool concerns(const SweepCase& one, const std::string& number);

}  // namespace veridyn::seek
