#pragma once

#include "veridyn/math/types.hpp"

namespace veridyn {

/// Smooth functions of a Gram matrix, of which a search wants the smallest; each writes its
/// derivative by the (symmetric) Gram matrix where asked to.
struct SmoothValue {
  double value = 0.0;
  MatrixXd by_gram;
};

/// Whether the columns of a regressor are divided by their norm (thesis 5.26).
enum class ColumnNorm { kOne, kAsTheyAre };

/// A smooth upper bound of ln(condition number), with the eigenvalues e of the (scaled) Gram
/// matrix:
///
///   1/(2p) ln(sum e^p) + 1/(2p) ln(sum e^-p)
///
/// It exceeds the logarithm by at most ln(size)/p. The condition number itself has kinks where
/// singular values cross; p, the sharpness, says how close to them one dares to go.
SmoothValue smooth_condition(const MatrixXd& gram, ColumnNorm norm, double sharpness);

/// - ln det(gram) / (2 size), columns divided by `scale`: the mean logarithm of the axes of the
/// confidence ellipsoid, up to a constant.
SmoothValue smooth_d_optimality(const MatrixXd& gram, const VectorXd& scale);

/// How columns of two rivals A and B stand among the nuisance columns, which come first.
struct RivalColumns {
  int nuisance = 0;
  int first = 0;   ///< columns of A
  int second = 0;  ///< columns of B, last
};

/// What is left of each rival's columns when nuisance and the other rival have explained what they
/// can: the geometric mean, over A's and B's columns, of the roots of the Schur complements (D_s
/// optimality both ways: Atkinson and Fedorov, Biometrika 62(1), 1975). Minus its logarithm.
SmoothValue smooth_discrimination(const MatrixXd& gram, const VectorXd& scale,
                                  const RivalColumns& rivals);

}  // namespace veridyn
