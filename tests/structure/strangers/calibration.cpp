#include <cmath>

#include "veridyn/calibration/remote_center.hpp"

// A body turns about the origin of the cameras; its own origin is 0.1 m away.
int main() {
  veridyn::PoseCapture poses;
  constexpr int kFrames = 200;
  poses.time = veridyn::VectorXd::LinSpaced(kFrames, 0.0, 1.0);
  for (int k = 0; k < kFrames; ++k) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = (Eigen::AngleAxisd(0.7 * std::sin(0.1 * k), Eigen::Vector3d::UnitX()) *
                     Eigen::AngleAxisd(0.6 * std::cos(0.23 * k), Eigen::Vector3d::UnitY()))
                        .toRotationMatrix();
    pose.translation() = -(pose.linear() * Eigen::Vector3d(0.0, 0.0, 0.1));
    poses.poses.push_back(pose);
  }
  return (veridyn::calibrate_remote_center(poses).tip - Eigen::Vector3d(0.0, 0.0, 0.1)).norm() < 1e-6 ? 0 : 1;
}
