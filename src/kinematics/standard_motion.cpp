#include "kinematics/standard_motion.hpp"

#include <algorithm>
#include <cmath>

#include "kinematics/motion_limits.hpp"

namespace veridyn {
namespace {

constexpr double kDuration = 30.0;  // [s] duration
constexpr double kRate = 100.0;     // [Hz] sample rate

}  // namespace

double standard_frequency(int joint) {
  return 0.2 + 0.07 * joint;
}

MotionSamples standard_motion(const Model& arm) {
  const MotionLimits limits = motion_limits(arm);
  const auto rows = static_cast<Eigen::Index>(kDuration * kRate) + 1;
  const Eigen::Index n = arm.joints();
  MotionSamples out{VectorXd::LinSpaced(rows, 0.0, kDuration), MatrixXd(rows, n), MatrixXd(rows, n),
                    MatrixXd(rows, n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const double omega = 2.0 * M_PI * standard_frequency(static_cast<int>(i));
    const double size =
        std::min({0.35 * (limits.upper[i] - limits.lower[i]), 0.5 * limits.velocity[i] / omega,
                  0.9 * limits.acceleration[i] / (omega * omega)});
    const double middle = 0.5 * (limits.lower[i] + limits.upper[i]);
    const Eigen::ArrayXd angle = omega * out.time.array();
    out.q.col(i) = middle + size * angle.sin();
    out.dq.col(i) = size * omega * angle.cos();
    out.ddq.col(i) = -size * omega * omega * angle.sin();
  }
  return out;
}

}  // namespace veridyn
