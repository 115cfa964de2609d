#pragma once

#include <Eigen/Core>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "support/random.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// The model with a body that could exist wherever it has one.
inline Model with_random_bodies(const Model& arm, unsigned seed) {
  ModelDescription description = arm.description();
  Random random(seed);
  for (Frame& frame : description.frames)
    if (frame.body) frame.body->phi = random.body();
  return Model(description);
}

/// Potential energy of the rows of a gravity file, with nothing of the library: poses of modified
/// DH rows multiplied out from the numbers in the JSON.
inline double potential_energy(const nlohmann::json& file, const std::vector<double>& q,
                               double gravity) {
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
  double energy = 0.0;
  for (std::size_t k = 0; k < q.size(); ++k) {
    const nlohmann::json& row = file.at("DH").at("joints").at(k);
    const bool prismatic = row.at("type") == "prismatic";
    const double variable = q[k] + row.at("offset").get<double>();
    const double theta = row.at("theta").get<double>() + (prismatic ? 0.0 : variable);
    const double d = row.at("D").get<double>() + (prismatic ? variable : 0.0);
    const double ca = std::cos(row.at("alpha").get<double>());
    const double sa = std::sin(row.at("alpha").get<double>());
    const double ct = std::cos(theta), st = std::sin(theta);
    Eigen::Matrix4d step;
    // clang-format off
    step << ct,      -st,      0.0, row.at("A").get<double>(),
            st * ca,  ct * ca, -sa, -d * sa,
            st * sa,  ct * sa,  ca,  d * ca,
            0.0,      0.0,     0.0, 1.0;
    // clang-format on
    T = T * step;
    const Eigen::Vector4d centre(row.at("cx"), row.at("cy"), row.at("cz"), 1.0);
    energy += row.at("mass").get<double>() * gravity * (T * centre).z();
  }
  return energy;
}

/// Torque of row k by central differences of the potential energy.
inline double gravity_by_differences(const nlohmann::json& file, std::vector<double> q,
                                     std::size_t k, double gravity) {
  const double step = 1e-5;
  q[k] += step;
  const double above = potential_energy(file, q, gravity);
  q[k] -= 2.0 * step;
  return (above - potential_energy(file, q, gravity)) / (2.0 * step);
}

}  // namespace veridyn
