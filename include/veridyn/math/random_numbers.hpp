#pragma once

#include <cmath>
#include <random>

namespace veridyn {

/// Random numbers that depend on the seed alone and not on the machine, unlike the distributions of
/// the standard library.
class RandomNumbers {
 public:
  /// @param stream  numbers of different streams of one seed are independent.
  explicit RandomNumbers(unsigned seed, unsigned stream = 0) {
    std::seed_seq sequence{seed, stream};
    engine_.seed(sequence);
  }

  /// A number that is uniform in [0, 1).
  double uniform() { return static_cast<double>(engine_()) * 0x1p-32; }

  /// A number that is uniform in [low, high).
  double uniform(double low, double high) { return low + (high - low) * uniform(); }

  /// A normal number of mean 0 and variance 1; Box and Muller, Annals of Mathematical Statistics 29(2), 1958.
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(2.0 * M_PI * uniform());
  }

 private:
  std::mt19937 engine_;
};

}  // namespace veridyn
