#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace veridyn::seek {

/// Random numbers that are equal on every machine, in one stream for every purpose.
class Draw {
 public:
  /// @param purpose  name of the stream; streams do not depend on each other.
  Draw(unsigned seed, const std::string& purpose) {
    std::uint64_t hash = 1469598103934665603ULL + seed;  // FNV-1a
    for (const char c : purpose) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
    engine_.seed(hash);
  }

  /// Uniform in [low, high).
  double in(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }

  /// Uniform in the logarithm.
  double log_in(double low, double high) { return std::exp(in(std::log(low), std::log(high))); }

  double sign() { return in(0.0, 1.0) < 0.5 ? -1.0 : 1.0; }

  /// Uniform in [low, high), with a random sign. The sign is drawn first: of two draws in one expression a compiler may
  /// take either first.
  double signed_in(double low, double high) {
    const double s = sign();
    return s * in(low, high);
  }

  /// One of 0 ... n - 1.
  int below(int n) { return std::min(n - 1, static_cast<int>(in(0.0, n))); }

  /// Standard normal (Box and Muller).
  double normal() {
    const double r = std::sqrt(-2.0 * std::log(1.0 - in(0.0, 1.0)));
    return r * std::cos(2.0 * M_PI * in(0.0, 1.0));
  }

  template <typename T>
  void shuffle(std::vector<T>& v) {
    for (int k = static_cast<int>(v.size()) - 1; k > 0; --k)
      std::swap(v[k], v[below(k + 1)]);
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace veridyn::seek
