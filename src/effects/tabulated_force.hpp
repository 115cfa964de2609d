#pragma once

namespace veridyn {

/// The effect of a residual that no cause of the list explains, see tabulated_force.cpp.
constexpr const char* kTabulatedForce = "tabulated_force";

/// What a table is of, and what its window looks at; the numbers are those of robot files.
enum class TableSignal {
  kNone = 0,
  kPosition = 1,
  kVelocity = 2,
  kLoad = 3,
  kDirection = 4,
  kFromPosition = 5,
  kFromVelocity = 6,
};

constexpr int kTableNodes = 13;

/// Place of node k, from 0, of a table between two places.
constexpr double table_node(double low, double high, int k) {
  return low + (high - low) * k / (kTableNodes - 1);
}

}  // namespace veridyn
