#pragma once

#include <utility>

#include "veridyn/math/types.hpp"

namespace veridyn {

/// Smooth functions of a Gram matrix for minimisation, with their derivative by the (symmetric)
/// Gram matrix on request.
struct SmoothValue {
  double value = 0.0;
  MatrixXd by_gram;
};

/// Scaling of a regressor's columns: divided by their norm (thesis 5.26) or unscaled.
enum class ColumnNorm { kOne, kAsTheyAre };

/// A smooth upper bound of ln(condition number), with the eigenvalues e of the (scaled) Gram
/// matrix:
///
///   1/(2p) ln(sum e^p) + 1/(2p) ln(sum e^-p)
///
/// It exceeds the logarithm by at most ln(size)/p. The condition number itself is not
/// differentiable where singular values cross; p is the sharpness of the approximation there.
SmoothValue smooth_condition(const MatrixXd& gram, ColumnNorm norm, double sharpness);

/// - ln det(gram) / (2 size), columns divided by `scale`: the mean logarithm of the axes of the
/// confidence ellipsoid, up to a constant.
SmoothValue smooth_d_optimality(const MatrixXd& gram, const VectorXd& scale);

/// Columns of two causes A and B after the nuisance columns.
struct RivalColumns {
  int nuisance = 0;
  /// One entry for each of A's columns: the size of its parameter. All zero if nuisance columns and B explain
  /// A completely, so that A is not identifiable on its own.
  VectorXd first;
  VectorXd second;  ///< entries for B, whose columns are the last
};

/// The mean square torque of a cause whose parameters have the given sizes, after regression on
/// other columns O:
///
///   S_A = sum over k of size_k^2 (G_AA - G_AO inv(G_OO) G_OA)_kk
struct RivalLeft {
  double left = 0.0;   ///< S_A if O are the nuisance columns and those of B
  double alone = 0.0;  ///< S_A if O are the nuisance columns
  MatrixXd left_by_gram, alone_by_gram;
};

/// Remainders of A and of B.
std::pair<RivalLeft, RivalLeft> rival_remainders(const MatrixXd& gram, const VectorXd& scale,
                                            const RivalColumns& rivals);

/// Mean over the identifiable causes of - 1/2 ln(left) + 1/4 ln(alone): one half is the torque that
/// distinguishes a cause from the other one (T-optimality: Atkinson and Fedorov, Biometrika 62(1), 1975), the
/// other half its share of the cause's torque. The share counts because a diagnosis cannot separate two
/// causes if one gains nearly as much as the other, however large both are.
SmoothValue smooth_discrimination(const MatrixXd& gram, const VectorXd& scale,
                                  const RivalColumns& rivals);

}  // namespace veridyn
