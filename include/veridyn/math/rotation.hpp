#pragma once

#include <Eigen/LU>

#include "veridyn/math/types.hpp"

namespace veridyn {

/// True if R (3 x 3) is finite, orthogonal within the tolerance and no mirror.
inline bool is_rotation(const Eigen::Ref<const MatrixXd>& R, double tolerance) {
  return R.rows() == 3 && R.cols() == 3 && R.allFinite() && (R * R.transpose()).isIdentity(tolerance) && R.determinant() > 0.0;
}

}  // namespace veridyn
