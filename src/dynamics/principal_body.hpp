#pragma once

#include "veridyn/math/types.hpp"
#include "veridyn/math/vector3.hpp"

namespace veridyn {

/// A body about its centre of mass, along its principal axes.
struct PrincipalBody {
  Eigen::Vector3d com;
  Eigen::Matrix3d axes;     ///< columns, right-handed
  Eigen::Vector3d moments;  ///< [kg m^2] ascending

  /// Whether these are the moments of a body, to rounding.
  bool possible() const;
};

/// Of ten parameters (m, m c, L about the origin) in the frame that stands at B, seen from where B
/// is given.
PrincipalBody principal_body(const double* phi, const Posed& B);

/// R as a matrix.
Eigen::Matrix3d rotation_matrix(const Mat3d& R);

}  // namespace veridyn
