#pragma once

#include <Eigen/Geometry>

#include "veridyn/math/vector3.hpp"

namespace veridyn {

// Conversions of the recursion's vectors, rotations and poses to Eigen's, and back.

inline Eigen::Vector3d eigen(const Vec3d& v) { return {v.x, v.y, v.z}; }

inline Eigen::Matrix3d eigen(const Mat3d& R) {
  Eigen::Matrix3d M;
  M << R.row0.x, R.row0.y, R.row0.z, R.row1.x, R.row1.y, R.row1.z, R.row2.x, R.row2.y, R.row2.z;
  return M;
}

inline Eigen::Isometry3d eigen(const Posed& T) {
  return Eigen::Translation3d(eigen(T.p)) * Eigen::Isometry3d(eigen(T.R));
}

inline Vec3d from_eigen(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

inline Mat3d from_eigen(const Eigen::Matrix3d& R) {
  return {{R(0, 0), R(0, 1), R(0, 2)}, {R(1, 0), R(1, 1), R(1, 2)}, {R(2, 0), R(2, 1), R(2, 2)}};
}

inline Posed from_eigen(const Eigen::Isometry3d& T) {
  return {from_eigen(Eigen::Matrix3d(T.linear())), from_eigen(Eigen::Vector3d(T.translation()))};
}

}  // namespace veridyn
