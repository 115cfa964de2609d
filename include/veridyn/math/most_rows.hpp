#pragma once

namespace veridyn {

/// Number of rows of this many numbers that fill a quarter of the machine's memory, which leaves
/// memory for copies and results. A request for more is a mistake in a rate or a duration and is
/// refused.
double most_rows(double numbers_per_row);

}  // namespace veridyn
