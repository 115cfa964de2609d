#pragma once

#include <Eigen/Core>
#include <cmath>
#include <random>
#include <vector>

#include "veridyn/math/vector3.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// Random numbers with a fixed seed, the same on every machine (std distributions differ between
/// libraries).
class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}

  /// Uniform in [low, high).
  double in(double low, double high) { return low + (high - low) * (engine_() * 0x1p-32); }

  Eigen::VectorXd vector(int size, double low, double high) {
    Eigen::VectorXd v(size);
    for (double& x : v) x = in(low, high);
    return v;
  }

  Posed pose(double reach) {
    const double roll = in(-M_PI, M_PI);
    const double pitch = in(-M_PI, M_PI);
    const double yaw = in(-M_PI, M_PI);
    return {rotation_z(yaw) * rotation_y(pitch) * rotation_x(roll),
            {in(-reach, reach), in(-reach, reach), in(-reach, reach)}};
  }

  /// A body that could exist: its mass spread around the centre with positive second moments.
  InertialParameters body() {
    const double mass = in(0.3, 4.0);
    const Eigen::Vector3d com = vector(3, -0.2, 0.2);
    const Mat3d R = pose(0.0).R;
    const Vec3d spread{in(1e-3, 4e-2), in(1e-3, 4e-2), in(1e-3, 4e-2)};
    const Mat3d I =
        R *
        Mat3d{
            {spread.y + spread.z, 0, 0}, {0, spread.x + spread.z, 0}, {0, 0, spread.x + spread.y}} *
        transpose(R);
    Eigen::Matrix<double, 6, 1> inertia;
    inertia << I.row0.x, I.row0.y, I.row1.y, I.row0.z, I.row1.z, I.row2.z;
    return inertial_parameters(mass, com, mass * inertia);
  }

 private:
  std::mt19937 engine_;
};

struct State {
  Eigen::VectorXd q, dq, ddq;
};

/// At rest in zero, all but at rest (1e-8), moving slowly through zero, and five moving anywhere.
inline std::vector<State> test_states(int joints, unsigned seed) {
  Random random(seed);
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(joints);
  std::vector<State> states{{zero, zero, zero}};
  states.push_back({random.vector(joints, -1e-8, 1e-8), random.vector(joints, -1e-8, 1e-8),
                    random.vector(joints, -1e-8, 1e-8)});
  states.push_back({zero, random.vector(joints, -1, 1), zero});
  for (int k = 0; k < 5; ++k) {
    states.push_back(
        {random.vector(joints, -3, 3), random.vector(joints, -2, 2), random.vector(joints, -5, 5)});
  }
  return states;
}

}  // namespace veridyn
