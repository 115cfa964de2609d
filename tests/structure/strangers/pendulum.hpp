#pragma once

#include <limits>

#include "veridyn/model/model.hpp"

// A rod of 2 kg that turns about a horizontal axis, half a metre off it.
inline veridyn::Model pendulum() {
  using namespace veridyn;
  constexpr double kFree = std::numeric_limits<double>::infinity();
  ModelDescription out;
  out.name = "pendulum";
  out.gravity = {0.0, -9.81, 0.0};
  out.coordinates = {{"swing", {-kFree, kFree, kFree, kFree, kFree}}};
  Frame rod;
  rod.name = "rod";
  rod.type = JointType::kRevolute;
  rod.variable.coefficients = VectorXd::Ones(1);
  rod.body = Body{inertial_parameters(2.0, {0.5, 0.0, 0.0}, Eigen::Matrix<double, 6, 1>::Zero()), {}};
  out.frames = {rod};
  return Model(out);
}
