#pragma once

#include <cstdint>
#include <vector>

#include "dvrk/protocol/bytes.hpp"

namespace veridyn::dvrk {

/// Faults of a bad network in one direction; shares of all, 0 to 1.
struct Mischief {
  double lose = 0.0;
  double repeat = 0.0;
  double corrupt = 0.0;     ///< one random bit
  double hold = 0.0;        ///< share that comes later than its followers: reordering
  double held_for = 0.001;  ///< [s]
  double delay = 0.0;       ///< [s] that every datagram takes
  double jitter = 0.0;      ///< [s] added to it, even from 0 on
  bool lose_writes = false;
};

/// One copy of a datagram in transit.
struct Copy {
  std::vector<std::uint8_t> bytes;
  double delay = 0.0;  ///< [s]
};

/// Draws the faults of datagrams, reproducibly by seed.
class Fate {
 public:
  explicit Fate(std::uint64_t seed) : state_(seed * 2 + 1) {}

  std::vector<Copy> of(ByteView datagram, const Mischief& mischief);

 private:
  double uniform();  ///< 0 to 1
  std::uint64_t state_;
};

/// Is it a request that writes? By the transaction code, section 3.1.
bool is_write(ByteView datagram);

}  // namespace veridyn::dvrk
