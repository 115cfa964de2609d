#pragma once

/// All numbers that can change what a regression finds, each with its inequality, and with its reason
/// where one is known. Those that a caller chooses are in AdditiveOptions.
namespace veridyn::estimation_numbers {

/// penalty of second differences / columns = one of kSmoothings, both scaled alike: from nearly free to
/// nearly straight.
constexpr double kSmoothings[] = {1e-3, 1e-1, 1e1, 1e3};
/// gain >= best gain - kAsSmooth * |best gain|: the smoothest of these is taken.
constexpr double kAsSmooth = 0.03;
/// ridge = kRidge * mean square of the columns: splines and the constant share a direction.
constexpr double kRidge = 1e-7;
/// mean square of one curve <= kLargest * that of the response. From 4 to 100 the same pairs of curves are
/// refused on recordings of an arm whose joints move as one (LWR4+); at 2 a memory's force there loses a fifth.
constexpr double kLargest = 4.0;
/// argument of a logarithm >= kLeast.
constexpr double kLeast = 1e-300;
/// degree of the splines = kDegree: cubic, with the four polynomials of smooth_basis.cpp.
constexpr int kDegree = 3;

}  // namespace veridyn::estimation_numbers
