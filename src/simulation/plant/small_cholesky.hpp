#pragma once

#include <cmath>

namespace veridyn {

// Triangular factors of the small mass matrices of arms: plain loops over column-major arrays
// (entry (i, j) at i + j n), which for a few joints are faster than a library's blocked code and
// never allocate.

/// Factors A = L L' in place, in the lower triangle, with the reciprocals of L's diagonal on the diagonal.
/// False if A is not positive definite, or contains NaN.
inline bool cholesky_in_place(double* A, int n) noexcept {
  for (int j = 0; j < n; ++j) {
    double* column = A + j * n;
    for (int k = 0; k < j; ++k) {
      const double* before = A + k * n;
      const double factor = before[j];
      if (factor == 0.0) continue;
      for (int i = j; i < n; ++i) column[i] -= factor * before[i];
    }
    if (!(column[j] > 0.0)) return false;
    const double inverse = 1.0 / std::sqrt(column[j]);
    for (int i = j + 1; i < n; ++i) column[i] *= inverse;
    column[j] = inverse;
  }
  return true;
}

/// Solves x <- L^-1 x.
inline void solve_lower(const double* L, int n, double* x) noexcept {
  for (int j = 0; j < n; ++j) {
    const double* column = L + j * n;
    if (x[j] == 0.0) continue;
    x[j] *= column[j];
    for (int i = j + 1; i < n; ++i) x[i] -= column[i] * x[j];
  }
}

/// Multiplies x <- L x.
inline void multiply_lower(const double* L, int n, double* x) noexcept {
  for (int j = n - 1; j >= 0; --j) {
    const double* column = L + j * n;
    for (int i = j + 1; i < n; ++i) x[i] += column[i] * x[j];
    x[j] /= column[j];
  }
}

/// Solves x <- L'^-1 x.
inline void solve_lower_transposed(const double* L, int n, double* x) noexcept {
  for (int j = n - 1; j >= 0; --j) {
    const double* column = L + j * n;
    double sum = x[j];
    for (int i = j + 1; i < n; ++i) sum -= column[i] * x[i];
    x[j] = sum * column[j];
  }
}

inline double dot(const double* a, const double* b, int n) noexcept {
  double sum = 0.0;
  for (int i = 0; i < n; ++i) sum += a[i] * b[i];
  return sum;
}

/// Computes y <- y + factor x.
inline void add_scaled(double factor, const double* x, int n, double* y) noexcept {
  for (int i = 0; i < n; ++i) y[i] += factor * x[i];
}

}  // namespace veridyn
