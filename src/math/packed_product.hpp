#pragma once

namespace veridyn {

/// C += alpha * A * B of blocks that Eigen has packed for kernels of 4 x 4 with two lanes: A by
/// panels of four rows, then one of two, then single rows; B by panels of four columns, then single
/// columns. Within a panel the entries of one inner index are adjacent.
struct PackedBlocks {
  const double* A;
  const double* B;
  double* C;    ///< first entry, stored by columns
  long stride;  ///< distance between columns of C
  long rows, depth, cols;
  long strideA, strideB;  ///< entries of a packed row, of a packed column
  long offsetA, offsetB;  ///< offset of the first inner index in a packed row, in a packed column
  double alpha;
};

/// Kernels for AVX2 with FMA, and for AVX-512; null if the build does not include them. Their results are equal
/// to the last bit.
void (*packed_product_avx2())(const PackedBlocks&);
void (*packed_product_avx512())(const PackedBlocks&);

}  // namespace veridyn
