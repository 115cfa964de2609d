#include "packed_product.hpp"

namespace veridyn {

// Compiled with -mavx2 -mfma on x86.
#if defined(__AVX2__) && defined(__FMA__)
namespace {

// One to three panels of kRows rows, times kColumns columns, in registers.
template <int kRows, int kPanels, int kColumns>
inline void multiply(const PackedBlocks& m, long row, long column) {
  typedef double Lanes __attribute__((vector_size(kRows * sizeof(double)), aligned(8), may_alias));
  const double* a = m.A + row * m.strideA + m.offsetA * kRows;
  const double* b = m.B + column * m.strideB + m.offsetB * kColumns;
  Lanes sum[kPanels][kColumns] = {};
  for (long k = 0; k < m.depth; ++k, a += kRows, b += kColumns) {
    for (int p = 0; p < kPanels; ++p) {
      const Lanes x = *reinterpret_cast<const Lanes*>(a + p * kRows * m.strideA);
      for (int c = 0; c < kColumns; ++c) sum[p][c] += x * b[c];
    }
  }
  for (int p = 0; p < kPanels; ++p) {
    for (int c = 0; c < kColumns; ++c) {
      Lanes* const to = reinterpret_cast<Lanes*>(m.C + (column + c) * m.stride + row + p * kRows);
      *to += m.alpha * sum[p][c];
    }
  }
}

template <int kColumns>
inline void all_rows(const PackedBlocks& m, long column) {
  long row = 0;
  for (; row + 12 <= m.rows; row += 12) multiply<4, 3, kColumns>(m, row, column);
  for (; row + 4 <= m.rows; row += 4) multiply<4, 1, kColumns>(m, row, column);
  for (; row + 2 <= m.rows; row += 2) multiply<2, 1, kColumns>(m, row, column);
  for (; row < m.rows; ++row) multiply<1, 1, kColumns>(m, row, column);
}

void packed_product(const PackedBlocks& m) {
  long column = 0;
  for (; column + 4 <= m.cols; column += 4) all_rows<4>(m, column);
  for (; column < m.cols; ++column) all_rows<1>(m, column);
}

}  // namespace

void (*packed_product_avx2())(const PackedBlocks&) {
  return &packed_product;
}
#else
void (*packed_product_avx2())(const PackedBlocks&) {
  return nullptr;
}
#endif

}  // namespace veridyn
