#include "simulated_capture.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibration/closed_forms.hpp"
#include "veridyn/kinematics/kinematics.hpp"
#include "veridyn/kinematics/motion_limits.hpp"

namespace veridyn {
namespace {

Eigen::Vector3d random_vector(RandomNumbers& random, double size) {
  const double z = random.normal(), y = random.normal(), x = random.normal();  // in one order with every compiler
  return size * Eigen::Vector3d(x, y, z);
}

Eigen::Isometry3d pose_of(const Model& arm, const VectorXd& q, std::optional<FrameIndex> frame) {
  return frame ? frame_pose(arm, q, *frame) : Eigen::Isometry3d::Identity();
}

// In the plane of the cranks the joint of a pair lies at kPivot plus so much along them.
const Eigen::Vector3d kPivot(0.1, 0.0, 0.2);
const Eigen::Vector3d kAcross(0.06, 0.0, 0.0);  // from the pivot of "near" to that of "far"
const Eigen::Vector3d kAlong[] = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0.15},
                                  {0, 0, 0.15}, {0, 0, 0.23}, {0, 0, 0.23}};

Eigen::Vector3d ladder_joint(int pair) {
  const bool far = pair == 2 || pair == 4 || pair == 6;
  return kPivot + kAlong[pair] + (far ? kAcross : Eigen::Vector3d::Zero());
}

}  // namespace

Eigen::Isometry3d random_pose(RandomNumbers& random, double reach) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = internal::rotation_of(random_vector(random, 0.8));
  T.translation() = random_vector(random, reach);
  return T;
}

Eigen::Isometry3d with_noise(const Eigen::Isometry3d& T, double metres, double radians,
                        RandomNumbers& random) {
  Eigen::Isometry3d out = T;
  out.linear() = T.linear() * internal::rotation_of(random_vector(random, radians));
  out.translation() += random_vector(random, metres);
  return out;
}

MarkerCapture captured_psm(const Model& arm, int frames, const CaptureNoise& noise, unsigned seed) {
  RandomNumbers random(seed, 3);
  const char* const names[] = {"base", "yaw", "upper", "elbow", "arm", "instrument"};
  const char* const frame_names[] = {"mount", "yaw", "upper", "elbow", "arm", "wrist"};
  const Eigen::Isometry3d camera = random_pose(random, 0.3);
  MarkerCapture out;
  out.source = "simulated";
  out.time = VectorXd::LinSpaced(frames, 0.0, 0.05 * (frames - 1));
  for (int b = 0; b < 6; ++b) {
    const std::optional<FrameIndex> frame = arm.find_frame(frame_names[b]);
    for (int m = 0; m < 3; ++m) {
      CapturedMarker marker;
      marker.body = names[b];
      marker.name = "m" + std::to_string(m + 1);
      marker.position.resize(3, frames);
      const Eigen::Vector3d x(0.05 * std::cos(2.2 * m + b), 0.06 * std::sin(2.2 * m + b),
                              0.02 * (m - 1));
      for (int k = 0; k < frames; ++k) {
        const double phase = 4.0 * M_PI * (k % (frames / 2)) / (0.5 * frames);
        VectorXd q = VectorXd::Zero(arm.joints());
        q[k < frames / 2 ? 0 : 1] = (k < frames / 2 ? 1.2 : 0.8) * std::sin(phase);
        Eigen::Vector3d p = camera * (pose_of(arm, q, frame) * x) +
                            random_vector(random, noise.marker);
        if (random.uniform() < noise.outliers) p += random_vector(random, noise.wrong);
        if (random.uniform() < noise.dropouts)
          p.setConstant(std::numeric_limits<double>::quiet_NaN());
        marker.position.col(k) = p;
      }
      out.markers.push_back(marker);
    }
  }
  return out;
}

MarkerCapture captured_ladder(unsigned seed, int frames, double noise, double play) {
  RandomNumbers random(seed, 3);
  const Eigen::Isometry3d camera = random_pose(random, 0.3);
  const std::string names[] = {"base", "yaw", "near", "far", "coupler", "outer"};
  MarkerCapture out;
  out.source = "simulated";
  out.time = VectorXd::LinSpaced(frames, 0.0, 0.05 * (frames - 1));
  for (int b = 0; b < 6; ++b) {
    for (int m = 0; m < 3; ++m) {
      CapturedMarker marker;
      marker.body = names[b];
      marker.name = "m" + std::to_string(m + 1);
      marker.position.resize(3, frames);
      const Eigen::Vector3d x(0.05 * std::cos(2.2 * m + b), 0.02 * (m - 1), 0.06 * std::sin(2.2 * m + b));
      for (int k = 0; k < frames; ++k) {
        const double phase = 4.0 * M_PI * (k % (frames / 2)) / (0.5 * frames);
        const Eigen::Matrix3d yaw =
            internal::rotation_of((k < frames / 2 ? 0.9 * std::sin(phase) : 0.0) * Eigen::Vector3d::UnitZ());
        const Eigen::Matrix3d crank =
            internal::rotation_of((k < frames / 2 ? 0.0 : 0.8 * std::sin(phase)) * Eigen::Vector3d::UnitY());
        const Eigen::Matrix3d open = internal::rotation_of(
            std::sqrt(2.0) * play / kAcross.norm() * std::sin(0.9 * k) * Eigen::Vector3d::UnitY());
        const Eigen::Vector3d places[] = {x,
                                   yaw * x,
                                   yaw * (kPivot + crank * x),
                                   yaw * (kPivot + kAcross + crank * x),
                                   yaw * (kPivot + crank * kAlong[3] + x),
                                   yaw * (kPivot + crank * kAlong[5] + open * x)};
        Eigen::Vector3d at = camera * places[b];
        for (int c = 0; c < 3; ++c) at[c] += noise * random.normal();
        marker.position.col(k) = at;
      }
      out.markers.push_back(marker);
    }
  }
  return out;
}

std::vector<std::pair<std::string, std::string>> ladder_pairs() {
  return {{"base", "yaw"},    {"yaw", "near"},   {"yaw", "far"},   {"near", "coupler"},
          {"far", "coupler"}, {"near", "outer"}, {"far", "outer"}};
}

int ladder_pair(const CalibratedAxis& axis) {
  const auto pairs = ladder_pairs();
  for (size_t k = 0; k < pairs.size(); ++k) {
    if ((axis.a == pairs[k].first && axis.b == pairs[k].second) ||
        (axis.b == pairs[k].first && axis.a == pairs[k].second))
      return static_cast<int>(k);
  }
  return -1;
}

double ladder_distance(const CalibratedAxis& first, const CalibratedAxis& second) {
  const int a = ladder_pair(first);
  const int b = ladder_pair(second);
  if (a == 0 || b == 0) return std::abs(ladder_joint(std::max(a, b)).x());
  return (ladder_joint(a) - ladder_joint(b)).norm();
}

PoseCapture capture_of(const std::vector<Eigen::Isometry3d>& poses) {
  PoseCapture out;
  out.source = "simulated";
  out.poses = poses;
  out.file_rows = static_cast<long>(poses.size());
  out.time = VectorXd::LinSpaced(out.frames(), 0.0, 0.1 * (out.frames() - 1));
  out.q.resize(out.frames(), 0);
  for (long k = 0; k < out.file_rows; ++k) out.rows.push_back(k);
  return out;
}

PoseCapture captured_poses(const Model& arm, const std::string& frame, int poses, double share,
                           double metres, double radians, unsigned seed,
                           const Eigen::Isometry3d& base, const Eigen::Isometry3d& tool) {
  RandomNumbers random(seed, 5);
  const MotionLimits limits = motion_limits(arm);
  std::vector<Eigen::Isometry3d> T;
  MatrixXd q(poses, arm.joints());
  for (int k = 0; k < poses; ++k) {
    for (int i = 0; i < arm.joints(); ++i) {
      const double half = 0.5 * share * (limits.upper[i] - limits.lower[i]);
      q(k, i) = 0.5 * (limits.upper[i] + limits.lower[i]) + random.uniform(-half, half);
    }
    T.push_back(with_noise(base * pose_of(arm, q.row(k), arm.find_frame(frame)) * tool, metres, radians,
                      random));
  }
  PoseCapture out = capture_of(T);
  out.q = q;
  return out;
}

}  // namespace veridyn
