#pragma once

namespace veridyn {

constexpr int kTrianglePanel = 8;  ///< columns that are triangulated together
constexpr int kTriangleRows = 4;   ///< divisor of the number of rows per call

/// One step of the streaming QR: the rows A go into the triangle R by Householder reflections,
///
///   [R; A]  ->  Q' [R; A] = [R'; 0]
///
/// Both row-major with `stride` doubles a row, aligned to 64 bytes; A is overwritten.
struct TriangleUpdate {
  double* R;        ///< (columns x columns), upper triangular
  double* A;        ///< (rows x columns)
  long stride;      ///< a multiple of kTrianglePanel, see triangle_stride()
  int columns;      ///< a multiple of kTrianglePanel; unused ones are zero
  /// Number of rows that begin before the end of each panel, (columns / kTrianglePanel), not decreasing,
  /// multiples of kTriangleRows; unused rows are zero. The rest of a panel is zero and is not read.
  const int* begun;
};

struct TriangleKernels {
  void (*update)(const TriangleUpdate& in) = nullptr;  ///< null: not compiled for this architecture
};

TriangleKernels triangle_kernels_baseline();
TriangleKernels triangle_kernels_avx2();
TriangleKernels triangle_kernels_avx512();

/// Kernels of the widest instruction set of this processor.
const TriangleKernels& triangle_kernels();

/// Columns rounded up to whole panels.
constexpr int triangle_columns(int columns) {
  return (columns + kTrianglePanel - 1) / kTrianglePanel * kTrianglePanel;
}

/// Distance of rows of this many columns: an odd number of cache lines, so that the entries of one column are
/// spread over all sets of the cache (a power of two halves the speed from 128 rows on).
constexpr long triangle_stride(int columns) {
  return (triangle_columns(columns) / kTrianglePanel | 1) * long{kTrianglePanel};
}

}  // namespace veridyn
