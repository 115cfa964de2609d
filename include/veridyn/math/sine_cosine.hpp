#pragma once

#include <cmath>

namespace veridyn {

/// Sine and cosine in one call; overloads for packs and dual numbers exist beside those types.
inline void sine_cosine(double x, double& sine, double& cosine) {
  sine = std::sin(x);
  cosine = std::cos(x);
}

inline void sine_cosine(float x, float& sine, float& cosine) {
  sine = std::sin(x);
  cosine = std::cos(x);
}

}  // namespace veridyn
