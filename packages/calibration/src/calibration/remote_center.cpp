#include "veridyn/calibration/remote_center.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "closed_forms.hpp"
#include "contradiction.hpp"
#include "deviations.hpp"
#include "veridyn/math/dense.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Row = Eigen::Matrix<double, 3, 6>;
using Normal = Eigen::Matrix<double, 6, 6>;

constexpr int kIterations = 12;
constexpr double kHuber = 2.0;          // standard deviations of a frame's residual
constexpr double kLeastNoise = 1e-9;    // [m], [rad] lower bound of the noise

// Weighted fit of rcm and tip, written with its statistics to `out`.
class PivotFit {
 public:
  PivotFit(const internal::Isometries& poses, RemoteCenter& out) : poses_(poses), out_(out) {}

  // False if fewer frames than `fewest` agree on any point.
  bool fit(double outlier, int fewest) {
    const std::size_t count = poses_.size();
    factors_.assign(count, 1.0);
    for (int k = 0; k < kIterations; ++k) {
      solve();
      estimate_noise();
      weigh(k + 3 < kIterations ? 0.0 : outlier);
      out_.outliers = static_cast<int>(std::count(out_.is_outlier.begin(), out_.is_outlier.end(), 1));
      if (static_cast<int>(count) - out_.outliers < fewest) return false;
    }
    solve();
    compute_statistics();
    return true;
  }

 private:
  // The equation rcm - R tip = p of one pose.
  static Row equation_row(const Eigen::Isometry3d& T) {
    Row J;
    J << Matrix3d::Identity(), -T.linear();
    return J;
  }

  // Inverse covariance of the residual of one pose.
  Matrix3d information(const Eigen::Isometry3d& T) const {
    const Vector3d t = out_.tip;
    Matrix3d C = (out_.position_noise * out_.position_noise) * Matrix3d::Identity();
    C += out_.orientation_noise * out_.orientation_noise *
         (t.squaredNorm() * Matrix3d::Identity() - t * t.transpose());
    return T.linear() * C.inverse() * T.linear().transpose();
  }

  void solve() {
    normal_.setZero();
    Eigen::Matrix<double, 6, 1> g = Eigen::Matrix<double, 6, 1>::Zero();
    for (std::size_t k = 0; k < poses_.size(); ++k) {
      const Row J = equation_row(poses_[k]);
      const Matrix3d W = factors_[k] * (weighted_ ? information(poses_[k]) : Matrix3d::Identity());
      normal_ += J.transpose() * W * J;
      g += J.transpose() * W * poses_[k].translation();
    }
    const Eigen::Matrix<double, 6, 1> x = symmetric_solution(normal_, g);
    out_.rcm = x.head<3>();
    out_.tip = x.tail<3>();
  }

  Vector3d residual(std::size_t k) const { return poses_[k] * out_.tip - out_.rcm; }

  // Along the tip only the position error counts; across it the orientation error too.
  void estimate_noise() {
    std::vector<double> along;
    std::vector<double> across;
    const double length = out_.tip.norm();
    const Vector3d t = length > 0.0 ? Vector3d(out_.tip / length) : Vector3d::UnitX();
    const Vector3d u = t.unitOrthogonal();
    const Vector3d v = t.cross(u);
    for (std::size_t k = 0; k < poses_.size(); ++k) {
      const Vector3d e = poses_[k].linear().transpose() * residual(k);
      along.push_back(e.dot(t));
      across.push_back(e.dot(u));
      across.push_back(e.dot(v));
    }
    const double p = internal::robust_deviation(along);
    const double a = internal::robust_deviation(across);
    out_.position_noise = std::max(kLeastNoise, std::min(p, a));
    const double beyond = a * a - out_.position_noise * out_.position_noise;
    out_.orientation_noise = length > 0.0 ? std::sqrt(std::max(0.0, beyond)) / length : 0.0;
    weighted_ = true;
  }

  // Sets Huber's weights or, with `outlier` > 0 standard deviations, marks outliers and weighs them by 0, inliers by 1.
  void weigh(double outlier) {
    out_.is_outlier.assign(poses_.size(), 0);
    for (std::size_t k = 0; k < poses_.size(); ++k) {
      const Vector3d r = residual(k);
      const double norm = std::sqrt(r.dot(information(poses_[k]) * r) / 3.0);
      factors_[k] = norm > kHuber ? kHuber / norm : 1.0;
      if (outlier <= 0.0) continue;
      out_.is_outlier[k] = norm > outlier ? 1 : 0;
      factors_[k] = norm > outlier ? 0.0 : 1.0;
    }
  }

  // Sets points, rms, correlation and half widths of the result.
  void compute_statistics() {
    std::vector<std::vector<double>> series(3);
    double chi2 = 0.0;
    Vector3d squares = Vector3d::Zero();
    Vector3d all = Vector3d::Zero();
    for (std::size_t k = 0; k < poses_.size(); ++k) {
      const Vector3d r = residual(k);
      out_.points.emplace_back(out_.rcm + r);
      all += r.cwiseAbs2();
      for (int c = 0; c < 3; ++c)
        series[c].push_back(out_.is_outlier[k] != 0 ? NAN : r[c]);
      if (out_.is_outlier[k] != 0) continue;
      squares += r.cwiseAbs2();
      chi2 += r.dot(information(poses_[k]) * r);
    }
    const auto count = static_cast<double>(poses_.size());
    const double kept = count - out_.outliers;
    out_.rms = (squares / kept).cwiseSqrt();
    out_.rms_all = (all / count).cwiseSqrt();
    out_.correlation = internal::correlation_factor(series);
    const double dof = std::max(1.0, (3.0 * kept - 6.0) / out_.correlation);
    const double scale = chi2 / std::max(1.0, 3.0 * kept - 6.0) * out_.correlation;
    const Normal covariance = scale * normal_.inverse();
    for (int c = 0; c < 3; ++c) {
      out_.rcm_half_width[c] = internal::half_width(covariance(c, c), dof);
      out_.tip_half_width[c] = internal::half_width(covariance(3 + c, 3 + c), dof);
      out_.rms_half_width[c] = internal::half_width(
          0.5 * out_.rms[c] * out_.rms[c] * out_.correlation / kept, dof);
    }
    out_.rcm_radius = internal::error_radius(covariance.topLeftCorner<3, 3>(), dof);
  }

  const internal::Isometries& poses_;
  RemoteCenter& out_;
  std::vector<double> factors_;
  Normal normal_;
  bool weighted_ = false;
};

// Sets the swing and the condition of `out`; returns the reason why the poses do not determine a centre, or
// empty.
std::string check_motion(const PoseCapture& poses, const RemoteCenterOptions& options,
                    RemoteCenter& out) {
  if (!poses.fault.empty()) return poses.fault;
  if (poses.frames() < options.fewest_frames) {
    return fmt::format("too few frames: {} with a pose, and {} or more are needed", poses.frames(),
                       options.fewest_frames);
  }
  const internal::RotationSpread spread = internal::rotation_spread(poses.poses);
  for (int c = 0; c < 3; ++c) out.swing[c] = std::sqrt(spread.eigenvalues[c]) / kDegree;
  // Singular values of (A.10) without the excluded frames: 1 +- sqrt(1 - spread) for every axis.
  const double least = 0.5 * spread.eigenvalues[0];
  out.condition = std::sqrt(2.0 / std::max(1e-300, least));
  if (out.swing[1] < options.smallest_swing) {
    return fmt::format("the body hardly turns ({:.2g} deg rms): sweeps about two axes are missing",
                       out.swing[2]);
  }
  if (out.swing[0] < options.smallest_swing) {
    const Vector3d axis = (spread.mean * spread.axes.col(0)).normalized();
    return fmt::format(
        "the body turns about one axis only, along ({:.2f}, {:.2f}, {:.2f}): {:.3g} deg rms about "
        "it, {:.2g} deg across; any point of that axis stays where it is, and a sweep about a "
        "second axis is missing",
        axis.x(), axis.y(), axis.z(), out.swing[2], out.swing[0]);
  }
  return "";
}

}  // namespace

RemoteCenter calibrate_remote_center(const PoseCapture& poses, const RemoteCenterOptions& options) {
  require(poses.has_orientation, poses.source,
          ": found positions only, expected orientations as well (qw, qx, qy, qz).");
  RemoteCenter out;
  out.source = poses.source;
  out.body = poses.body;
  out.frames = poses.frames();
  out.poses = poses.poses;
  out.reason = check_motion(poses, options, out);
  if (!out.reason.empty()) return out;
  PivotFit fit(out.poses, out);
  if (fit.fit(options.outlier, options.fewest_frames)) {
    out.reason = internal::contradiction_reason(out.poses, {out.outliers, out.rms.norm(), 0.0});
    if (!out.reason.empty())
      out.reason = "no point stays where it is: " + out.reason + "; the body may slide while it turns";
    else
      out.status = CalibrationStatus::kDone;
  } else {
    out.reason = fmt::format(
        "no point stays where it is: {} of {} frames contradict any centre, and {} or more that "
        "agree are needed; the body may slide while it turns",
        out.outliers, out.frames, options.fewest_frames);
  }
  return out;
}

std::string RemoteCenter::report() const {
  if (status != CalibrationStatus::kDone) return "Remote centre: " + reason + ".\n";
  const auto line = [](const char* name, const Vector3d& v, const Vector3d& half) {
    return fmt::format("  {:<22}{:10.3f}{:10.3f}{:10.3f}   +- {:.3f} {:.3f} {:.3f}\n", name,
                       1e3 * v.x(), 1e3 * v.y(), 1e3 * v.z(), 1e3 * half.x(), 1e3 * half.y(),
                       1e3 * half.z());
  };
  std::string text = fmt::format("Remote centre from {} frames, {} of them left out [mm]\n", frames,
                                 outliers);
  text += fmt::format("  {:<22}{:>10}{:>10}{:>10}   95 %\n", "", "x", "y", "z");
  text += line("centre, cameras", rcm, rcm_half_width);
  text += line("centre, body", tip, tip_half_width);
  text += line("rms over the frames", rms, rms_half_width);
  text += fmt::format(
      "  The centre lies within {:.3f} mm (95 %). The body turned by {:.1f}, {:.1f} and {:.1f} deg "
      "rms; condition number of the equations {:.1f}.\n",
      1e3 * rcm_radius, swing[0], swing[1], swing[2], condition);
  text += fmt::format("  Noise: {:.3f} mm of position, {:.3f} deg of orientation; one independent "
                      "frame in {:.1f}.\n",
                      1e3 * position_noise, orientation_noise / kDegree, correlation);
  return text;
}

}  // namespace veridyn
