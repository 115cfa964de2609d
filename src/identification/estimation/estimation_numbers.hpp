#pragma once

namespace veridyn {

/// All numbers that can change what a regression finds, each with its inequality, and with its reason
/// where one is known. Those that a caller chooses are in AdditiveOptions.
struct EstimationNumbers {
  /// penalty of second differences / columns = one of `smoothings` values from least_smoothing on, each
  /// smoothing_step = times the one before; both scaled alike: from nearly free to nearly straight.
  double least_smoothing = 1e-3, smoothing_step = 100.0;
  /// the number of these = smoothings.
  int smoothings = 4;
  /// gain >= best gain - as_smooth * |best gain|: the smoothest of these is taken.
  double as_smooth = 0.03;
  /// ridge = ridge * mean square of the columns: splines and the constant share a direction.
  double ridge = 1e-7;
  /// mean square of one curve <= largest * that of the response. From 4 to 100 the same pairs of curves are
  /// refused on recordings of an arm whose joints move as one (LWR4+); at 2 a memory's force there loses a fifth.
  double largest = 4.0;
};

namespace estimating {

/// argument of a logarithm >= kLeast.
constexpr double kLeast = 1e-300;
/// degree of the splines = kDegree: cubic, with the four polynomials of smooth_basis.cpp.
constexpr int kDegree = 3;

}  // namespace estimating

}  // namespace veridyn
