#pragma once

#include "veridyn/math/types.hpp"

namespace veridyn {

/// Which functions of one signal a basis spans.
enum class BasisKind {
  kSmooth,  ///< one smooth function
  kSided,   ///< a smooth function and a step at zero: velocities, ways since a reversal
  kSides,   ///< one number on either side of zero: a direction
};

/// Cubic B-splines over equal intervals of a signal's range, constant outside of it, with a penalty
/// on second differences of neighbouring coefficients:
///
///   f(x) = sum_k a_k B_k(x),   penalty = sum_k (a_k - 2 a_(k+1) + a_(k+2))^2
///
/// Source: Eilers and Marx, Statistical Science 11(2), 1996 (P-splines).
class SmoothBasis {
 public:
  /// @param low, high   range of the signal; low < high. Of kSides they count for nothing.
  /// @param intervals   of the splines.
  /// @param step        half the width of the step at zero, in the signal's unit.
  SmoothBasis(BasisKind kind, double low, double high, int intervals, double step);

  Eigen::Index size() const;

  /// The functions' values at x, size() entries.
  void values(double x, double* out) const;

  /// (size x size), positive semidefinite.
  MatrixXd penalty() const;

  BasisKind kind() const { return kind_; }
  double low() const { return low_; }
  double high() const { return high_; }

 private:
  BasisKind kind_;
  double low_, high_;
  int intervals_;
  double step_;
};

}  // namespace veridyn
