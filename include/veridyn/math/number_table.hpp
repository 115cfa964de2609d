#pragma once

#include <cmath>
#include <string>
#include <type_traits>
#include <vector>

#include "veridyn/math/require.hpp"

namespace veridyn {

/// A number of a room's table, by its name. A sweep multiplies it and looks which answers change.
template <typename Numbers>
struct TableNumber {
  std::string name;
  bool whole;  ///< an integer: set() rounds
  double (*in)(const Numbers&);
  void (*set)(Numbers&, double);
};

template <typename Numbers, typename Value>
Numbers table_of(Value Numbers::*place);
template <typename Numbers, typename Value>
Value type_of(Value Numbers::*place);

/// The number at a member: number_of<&WatchNumbers::odds>("odds").
template <auto place>
auto number_of(const char* name) {
  using Numbers = decltype(table_of(place));
  constexpr bool kWhole = std::is_same_v<decltype(type_of(place)), int>;
  return TableNumber<Numbers>{name, kWhole, [](const Numbers& numbers) { return static_cast<double>(numbers.*place); },
                              [](Numbers& numbers, double value) {
                                if constexpr (kWhole) {
                                  numbers.*place = static_cast<int>(std::lround(value));
                                } else {
                                  numbers.*place = value;
                                }
                              }};
}

/// @throws InvalidInput  the table has no number of this name.
template <typename Numbers>
const TableNumber<Numbers>& number_named(const std::vector<TableNumber<Numbers>>& table, const std::string& name) {
  for (const TableNumber<Numbers>& one : table) {
    if (one.name == name) return one;
  }
  throw InvalidInput("found the number '" + name + "', expected one of " + table.front().name + ", ..., " +
                     table.back().name + ".");
}

/// The numbers with one of them multiplied.
template <typename Numbers>
Numbers multiplied(Numbers numbers, const TableNumber<Numbers>& number, double factor) {
  number.set(numbers, factor * number.in(numbers));
  return numbers;
}

}  // namespace veridyn
