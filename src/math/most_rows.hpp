#pragma once

namespace veridyn {

/// How many rows of this many numbers may be held on this machine: what fills a quarter of its
/// memory, so that copies and results have room beside them. More are a mistake in a rate or a
/// duration, and better refused than begun.
double most_rows(double numbers_per_row);

}  // namespace veridyn
