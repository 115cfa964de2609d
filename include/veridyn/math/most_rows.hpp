#pragma once

namespace veridyn {

/// Number of rows of this many doubles that fill a quarter of the machine's memory; the rest remains for copies
/// and results. Callers refuse to create more, since a larger number results from a wrong rate or duration.
double most_rows(double numbers_per_row);

}  // namespace veridyn
