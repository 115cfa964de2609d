#pragma once

#include "veridyn/control/computed_torque.hpp"
#include "veridyn/math/motion_samples.hpp"

namespace veridyn::dvrk {

/// A motion at any time: cubics through q and dq of the rows, at rest outside of them; ddq is that
/// of the cubics, linear between rows, with steps at them. Call it in ascending time; nothing
/// allocates after the constructor.
class SetPoints {
 public:
  explicit SetPoints(const MotionSamples& motion) : motion_(motion) {}

  double duration() const { return motion_.time[motion_.rows() - 1] - motion_.time[0]; }  ///< [s]

  /// @param t  [s] since the first row. @param point  the motion's joints are written.
  void at(double t, JointReference& point) noexcept {
    const Eigen::Index last = motion_.rows() - 1;
    const double time = motion_.time[0] + t;
    while (row_ < last && motion_.time[row_ + 1] <= time) ++row_;
    if (row_ >= last || t <= 0.0) {
      const Eigen::Index r = t <= 0.0 ? 0 : last;
      for (Eigen::Index j = 0; j < motion_.joints(); ++j) {
        point.q[j] = motion_.q(r, j);
        point.dq[j] = point.ddq[j] = 0.0;
      }
      return;
    }
    const double h = motion_.time[row_ + 1] - motion_.time[row_];
    const double s = (time - motion_.time[row_]) / h;
    const double a = s * s * (3.0 - 2.0 * s);
    for (Eigen::Index j = 0; j < motion_.joints(); ++j) {
      const double q0 = motion_.q(row_, j), q1 = motion_.q(row_ + 1, j);
      const double v0 = motion_.dq(row_, j), v1 = motion_.dq(row_ + 1, j);
      point.q[j] = q0 + a * (q1 - q0) + h * s * (1.0 - s) * ((1.0 - s) * v0 - s * v1);
      point.dq[j] = 6.0 * s * (1.0 - s) * (q1 - q0) / h + (1.0 - s) * (1.0 - 3.0 * s) * v0 +
                    s * (3.0 * s - 2.0) * v1;
      point.ddq[j] =
          (6.0 * (1.0 - 2.0 * s) * (q1 - q0) / h + (6.0 * s - 4.0) * v0 + (6.0 * s - 2.0) * v1) / h;
    }
  }

 private:
  const MotionSamples& motion_;
  Eigen::Index row_ = 0;
};

}  // namespace veridyn::dvrk
