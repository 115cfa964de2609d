#pragma once

#include <utility>

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
  /// One entry for each of A's columns: the size that its parameter may have. All zero where
  /// nuisance and B explain whatever A does, so that A alone can never be seen.
  VectorXd first;
  VectorXd second;  ///< the same of B, whose columns are the last
};

/// The mean square torque of a rival whose parameters are drawn with the given sizes, when others
/// have explained what they can:
///
///   S_A = sum over k of size_k^2 (G_AA - G_AO inv(G_OO) G_OA)_kk
struct RivalLeft {
  double left = 0.0;   ///< O: nuisance and B
  double alone = 0.0;  ///< O: nuisance
  MatrixXd left_by_gram, alone_by_gram;
};

/// Of A and of B.
std::pair<RivalLeft, RivalLeft> rivals_left(const MatrixXd& gram, const VectorXd& scale,
                                            const RivalColumns& rivals);

/// Of each rival that can be seen, in the mean: - 1/2 ln(left) + 1/4 ln(alone), that is minus half
/// the logarithm of how much of its torque tells it from the other (T optimality: Atkinson and
/// Fedorov, Biometrika 62(1), 1975), and minus half of which share. The share counts because a
/// diagnosis holds two causes for rivals when one gains nearly as much as the other, however large
/// both are.
SmoothValue smooth_discrimination(const MatrixXd& gram, const VectorXd& scale,
                                  const RivalColumns& rivals);

}  // namespace veridyn
