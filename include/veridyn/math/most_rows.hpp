#pragma once

namespace veridyn {

/// Number of rows with this many numbers each that fill a quarter of the machine's memory; the rest is for
/// copies and results. A larger request comes from a wrong rate or duration and is refused.
double most_rows(double numbers_per_row);

}  // namespace veridyn
