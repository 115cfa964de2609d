#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "math/number_table.hpp"
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

/// A case of a room whose numbers are a struct with a table.
template <typename Numbers>
using TableCase = std::pair<std::string, std::function<SweepAnswer(const Numbers&)>>;

/// The room of such a table; every case is asked for every number.
template <typename Numbers>
SweptRoom room_of(const std::vector<TableNumber<Numbers>>& table, const std::vector<TableCase<Numbers>>& cases) {
  SweptRoom out;
  for (const TableNumber<Numbers>& one : table) out.numbers.push_back(one.name);
  out.value = [&table](const std::string& number) { return number_named(table, number).in(Numbers()); };
  for (const TableCase<Numbers>& one : cases) {
    const auto ask = [&table, asked = one.second](const std::string& number, double factor) {
      return asked(multiplied(Numbers(), number_named(table, number), factor));
    };
    out.cases.push_back({one.first, ask, [](const std::string&) { return true; }});
  }
  return out;
}

/// The numbers of `diagnose`. @param folder  of the recordings; it stays as long as the cases are asked.
SweptRoom diagnosis_room(const DiagnosisOptions& options, unsigned seed, const std::string& folder);

/// The numbers of the quality of recordings: sound ones, and ones with planted faults.
SweptRoom quality_room(unsigned seed, const std::string& folder);

/// The numbers of regressions with smooth terms: curves under noise.
SweptRoom estimation_room(unsigned seed);

/// The numbers of `watch`: simulated arms that change while they are watched.
SweptRoom watch_room(unsigned seed);

/// The numbers of `compare`: pairs of models before and after something happened to the arm.
SweptRoom comparison_room(unsigned seed, const std::string& folder);

/// The numbers of `fleet`: arms of one type, one of them odd.
SweptRoom fleet_room(unsigned seed);

/// The numbers of `identify`: recordings, poses and known masses with a known right answer.
SweptRoom identification_room(unsigned seed, const std::string& folder);

}  // namespace veridyn::seek
