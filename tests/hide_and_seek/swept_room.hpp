#pragma once

#include <functional>
#include <string>
#include <vector>

#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn::seek {

/// What the tool says of a case of a small board.
struct SweepAnswer {
  bool right = false;  ///< all that is hidden is named, or said in the right words, and nothing else
  std::string said;    ///< names, places, rivals, states of joints, faults of recordings; no numbers
};

/// A case of a room whose numbers are swept.
struct RoomCase {
  std::string name;
  /// The answer with a number of the room multiplied by a factor.
  std::function<SweepAnswer(const std::string& number, double factor)> ask;
  std::function<bool(const std::string& number)> concerns;  ///< false: not asked for this number
};

/// Numbers that decide an answer, and the cases on which they are swept.
struct SweptRoom {
  std::vector<std::string> numbers;
  std::function<double(const std::string& number)> value;
  std::vector<RoomCase> cases;
};

/// The numbers of `diagnose`. @param folder  of the recordings; it stays as long as the cases are asked.
SweptRoom diagnosis_room(const DiagnosisOptions& options, unsigned seed, const std::string& folder);

/// The numbers of `check ROBOT`: sound and mistaken recordings of a SCARA and the first axes of a PSM.
SweptRoom check_room(unsigned seed, const std::string& folder);

}  // namespace veridyn::seek
