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

/// Cubic B-splines over equal intervals of a signal's range, constant outside of it:
///
///   f(x) = sum_k a_k B_k(x)
class SmoothBasis {
 public:
  /// @param low, high   range of the signal; low < high. Ignored for kSides.
  /// @param intervals   number of spline intervals.
  /// @param step        half the width of the step at zero, in the signal's unit.
  SmoothBasis(BasisKind kind, double low, double high, int intervals, double step);

  Eigen::Index size() const;

  /// Writes the values of the functions at x, size() entries.
  void values(double x, double* out) const;

  BasisKind kind() const { return kind_; }

 private:
  BasisKind kind_;
  double low_, high_;
  int intervals_;
  double step_;
};

}  // namespace veridyn
