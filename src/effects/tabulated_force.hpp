#pragma once

namespace veridyn {

/// The effect that represents a residual without a known cause, see tabulated_force.cpp.
constexpr const char* kTabulatedForce = "tabulated_force";

/// Signals of a table and of its window, with their numbers in robot files.
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

/// Position of node k, from 0, of a table between low and high.
constexpr double table_node(double low, double high, int k) {
  return low + (high - low) * k / (kTableNodes - 1);
}

}  // namespace veridyn
