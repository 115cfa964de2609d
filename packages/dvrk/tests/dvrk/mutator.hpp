#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "dvrk/vectors.hpp"

namespace veridyn::dvrk {

/// Changes datagrams at random: bits, bytes, lengths, length fields, other packets behind them.
class Mutator {
 public:
  explicit Mutator(std::uint64_t seed) : random_(seed) {
    for (const Vector& v : vectors()) seeds_.push_back(bytes_of(v.hex));
    bytes_.reserve(4096);
  }

  /// A captured datagram, changed up to four times.
  const std::vector<std::uint8_t>& next() {
    bytes_ = seeds_[pick(seeds_.size())];
    for (size_t k = 1 + pick(4); k > 0; --k) mutate();
    return bytes_;
  }

  /// These bytes, changed once.
  const std::vector<std::uint8_t>& changed(ByteView of) {
    bytes_.assign(of.data, of.data + of.size);
    if (!bytes_.empty()) mutate();
    return bytes_;
  }

  size_t pick(size_t below) { return static_cast<size_t>(random_() % below); }

 private:
  void mutate() {
    switch (pick(6)) {
      case 0:
        bytes_[pick(bytes_.size())] ^= static_cast<std::uint8_t>(1U << pick(8));
        break;
      case 1:
        bytes_[pick(bytes_.size())] = static_cast<std::uint8_t>(random_());
        break;
      case 2:
        bytes_.resize(1 + pick(bytes_.size()));
        break;
      case 3:
        bytes_.resize(bytes_.size() + pick(64), static_cast<std::uint8_t>(random_()));
        break;
      case 4: {  // another packet behind it
        const std::vector<std::uint8_t>& other = seeds_[pick(seeds_.size())];
        if (bytes_.size() + other.size() < 4000)
          bytes_.insert(bytes_.end(), other.begin(), other.end());
        break;
      }
      default:  // a length field
        if (bytes_.size() > 15) bytes_[12 + pick(4)] = static_cast<std::uint8_t>(4 * pick(64));
    }
  }

  std::mt19937_64 random_;
  std::vector<std::vector<std::uint8_t>> seeds_;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace veridyn::dvrk
