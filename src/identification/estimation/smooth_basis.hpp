#pragma once

#include "veridyn/math/types.hpp"

namespace veridyn {

/// Functions of one signal, spanned by a basis.
enum class BasisKind {
  kSmooth,  ///< one smooth function
  /// A smooth function and a step at zero: for velocities and displacements since a reversal.
  kSided,
  kSides,  ///< one value on either side of zero, for directions
};

/// Cubic B-splines over equal intervals of a signal's range, constant outside of it, with a penalty
/// on second differences of neighbouring coefficients:
///
///   f(x) = sum_k a_k B_k(x),   penalty = sum_k (a_k - 2 a_(k+1) + a_(k+2))^2
///
/// Source: Eilers and Marx, Statistical Science 11(2), 1996 (P-splines).
class SmoothBasis {
 public:
  /// @param low, high   range of the signal; low < high. Ignored for kSides.
  /// @param intervals   number of spline intervals.
  /// @param step        half the width of the step at zero, in the signal's unit.
  SmoothBasis(BasisKind kind, double low, double high, int intervals, double step);

  Eigen::Index size() const;

  /// Writes the values of the functions at x, size() entries.
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
