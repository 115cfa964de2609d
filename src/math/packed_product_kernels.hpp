#pragma once

#include "math/packed_product.hpp"

// The product of packed blocks, compiled by each packed_product_<isa>.cpp with flags of its own: all
// of it is in an unnamed namespace, so that the linker never exchanges one copy for another. Every
// entry is the sum of its products in order, whatever the width.

namespace veridyn {
namespace {

typedef double Four __attribute__((vector_size(4 * sizeof(double)), aligned(8), may_alias));
typedef double Eight __attribute__((vector_size(8 * sizeof(double))));

// Loads four entries of one panel and four of the next.
inline Eight pair(const double* a, long next) {
  const Four low = *reinterpret_cast<const Four*>(a);
  const Four high = *reinterpret_cast<const Four*>(a + next);
  return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
}

// Multiplies kVectors vectors of kJoined panels of kRows rows by kColumns columns, in registers.
template <int kRows, int kJoined, int kVectors, int kColumns>
inline void multiply(const PackedBlocks& m, long row, long column) {
  typedef double Lanes __attribute__((vector_size(kRows * kJoined * sizeof(double)), aligned(8), may_alias));
  constexpr int kPanel = kColumns < 4 ? kColumns : 4;  // columns of a panel of B
  const double* a = m.A + row * m.strideA + m.offsetA * kRows;
  const double* b = m.B + column * m.strideB + m.offsetB * kPanel;
  Lanes sum[kVectors][kColumns] = {};
  for (long k = 0; k < m.depth; ++k, a += kRows, b += kPanel) {
    Lanes x[kVectors];
    for (int p = 0; p < kVectors; ++p) {
      const double* const first = a + p * kJoined * kRows * m.strideA;
      if constexpr (kJoined == 2) {
        const Eight both = pair(first, kRows * m.strideA);
        x[p] = *reinterpret_cast<const Lanes*>(&both);
      } else {
        x[p] = *reinterpret_cast<const Lanes*>(first);
      }
    }
    for (int c = 0; c < kColumns; ++c) {
      const double y = b[c / kPanel * kPanel * m.strideB + c % kPanel];
      for (int p = 0; p < kVectors; ++p) sum[p][c] += x[p] * y;
    }
  }
  for (int p = 0; p < kVectors; ++p) {
    for (int c = 0; c < kColumns; ++c) {
      Lanes* const to = reinterpret_cast<Lanes*>(m.C + (column + c) * m.stride + row + p * kRows * kJoined);
      *to += m.alpha * sum[p][c];
    }
  }
}

// Multiplies all rows by the kColumns columns from `column` on, kJoined panels of four rows at once where possible.
template <int kJoined, int kColumns>
inline void all_rows(const PackedBlocks& m, long column) {
  long row = 0;
  for (; row + 12 * kJoined <= m.rows; row += 12 * kJoined) multiply<4, kJoined, 3, kColumns>(m, row, column);
  // At least eight sums are computed at once, so that additions do not wait for each other.
  for (; kColumns < 8 && row + 12 <= m.rows; row += 12) multiply<4, 1, 3, kColumns>(m, row, column);
  for (; row + 4 * kJoined <= m.rows; row += 4 * kJoined) multiply<4, kJoined, 1, kColumns>(m, row, column);
  for (; row + 4 <= m.rows; row += 4) multiply<4, 1, 1, kColumns>(m, row, column);
  for (; row + 2 <= m.rows; row += 2) multiply<2, 1, 1, kColumns>(m, row, column);
  for (; row < m.rows; ++row) multiply<1, 1, 1, kColumns>(m, row, column);
}

// Multiplies kJoined panels of four rows, or of four columns, at once.
template <int kJoined>
void packed_product(const PackedBlocks& m) {
  long column = 0;
  for (; column + 4 * kJoined <= m.cols; column += 4 * kJoined) all_rows<kJoined, 4 * kJoined>(m, column);
  for (; column + 4 <= m.cols; column += 4) all_rows<kJoined, 4>(m, column);
  for (; column < m.cols; ++column) all_rows<kJoined, 1>(m, column);
}

}  // namespace
}  // namespace veridyn
