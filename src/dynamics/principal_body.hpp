#pragma once

#include "veridyn/math/types.hpp"
#include "veridyn/math/vector3.hpp"

namespace veridyn {

/// A body about its centre of mass, along its principal axes.
struct PrincipalBody {
  Eigen::Vector3d com;
  Eigen::Matrix3d axes;     ///< principal axes as columns, right-handed
  Eigen::Vector3d moments;  ///< [kg m^2] ascending

  /// True if the moments satisfy the triangle inequality, up to rounding.
  bool possible() const;
};

/// Converts ten parameters (m, m c, L about the origin), given in a frame with pose B, into the
/// parent frame of B.
PrincipalBody principal_body(const double* phi, const Posed& B);

}  // namespace veridyn
