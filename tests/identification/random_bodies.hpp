#pragma once

#include <Eigen/Dense>
#include <random>

#include "veridyn/identification/pseudo_inertia.hpp"

namespace veridyn {

inline MatrixXd random_matrix(int rows, int columns, std::mt19937& generator) {
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, columns, [&]() { return normal(generator); });
}

/// A body of positive mass: a cloud of 20 points.
inline InertialVector random_body(std::mt19937& generator) {
  Eigen::Matrix4d J = Eigen::Matrix4d::Zero();
  for (int point = 0; point < 20; ++point) {
    Eigen::Vector4d r;
    r << 0.2 * random_matrix(3, 1, generator), 1.0;
    J += 0.1 * r * r.transpose();
  }
  return inertial_parameters(J);
}

}  // namespace veridyn
