#pragma once

#include "veridyn/math/sine_cosine.hpp"

namespace veridyn {

/// A number with its derivative: f(x + e dx) = f(x) + e f'(x) dx with e^2 = 0. Nests:
/// Dual<Dual<double>> carries second derivatives.
template <typename S>
struct Dual {
  S value{};
  S derivative{};

  Dual() = default;
  Dual(double v) : value(v), derivative(0.0) {}  // NOLINT: a constant has no derivative
  Dual(const S& v, const S& d) : value(v), derivative(d) {}

  Dual& operator+=(const Dual& b) { return *this = *this + b; }
  Dual& operator-=(const Dual& b) { return *this = *this - b; }
  friend Dual operator+(const Dual& a, const Dual& b) {
    return {a.value + b.value, a.derivative + b.derivative};
  }
  friend Dual operator-(const Dual& a, const Dual& b) {
    return {a.value - b.value, a.derivative - b.derivative};
  }
  friend Dual operator-(const Dual& a) { return {-a.value, -a.derivative}; }
  friend Dual operator*(const Dual& a, const Dual& b) {
    return {a.value * b.value, a.value * b.derivative + a.derivative * b.value};
  }
  friend Dual operator*(double a, const Dual& b) { return {a * b.value, a * b.derivative}; }
  friend Dual operator/(const Dual& a, const Dual& b) {
    const S q = a.value / b.value;
    return {q, (a.derivative - q * b.derivative) / b.value};
  }
};

template <typename S>
inline void sine_cosine(const Dual<S>& x, Dual<S>& sine, Dual<S>& cosine) {
  S s{};
  S c{};
  sine_cosine(x.value, s, c);
  sine = {s, c * x.derivative};
  cosine = {c, -(s * x.derivative)};
}

}  // namespace veridyn
