#pragma once

#include <vector>

namespace veridyn {

/// Amplitudes 2/n |sum of r exp(-i w s)| of the waves along s in r at evenly spaced angular frequencies.
///
/// @param s      positions, not necessarily evenly spaced, (n)
/// @param r      values there, (n)
/// @param first  first angular frequency, rad per unit of s
/// @param step   distance of the frequencies
std::vector<double> line_amplitudes(const std::vector<double>& s, const std::vector<double>& r, double first,
                                    double step, size_t count);

}  // namespace veridyn
