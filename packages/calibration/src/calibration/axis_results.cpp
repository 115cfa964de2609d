#include "axis_results.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>

#include "deviations.hpp"
#include "hinge_path.hpp"

namespace veridyn::internal {
namespace {

using Eigen::Vector3d;

constexpr double kStep = 1e-6;                // [rad], [m] step of the differences
constexpr double kSamePlace = 0.5 * kDegree;  // range within which the joints above count as resting
constexpr double kSweepShare = 0.5;  // share of a joint's range that it must cover during that rest
constexpr std::size_t kFewestAtRest = 10;
constexpr double kParallel = 0.2 * kDegree;   // axes with a smaller angle have no common normal
constexpr double kSharePlane = 10.0 * kDegree;

// Frames at which all joints above rest at one position while this one sweeps; empty: there are
// none.
std::vector<int> frames_at_rest(const HingeBundle& bundle, int hinge) {
  const std::vector<int> above = bundle.path_from_root(hinge);
  const int n = bundle.frames();
  std::vector<int> all(n);
  for (int k = 0; k < n; ++k) all[k] = k;
  if (above.empty()) return all;
  if (!bundle.tree().root_rests) return {};
  MatrixXd q(n, static_cast<Eigen::Index>(above.size()));
  for (std::size_t j = 0; j < above.size(); ++j)
    q.col(j) = bundle.angles(above[j]);
  const VectorXd own = bundle.angles(hinge);
  std::vector<int> best;
  double widest = 0.0;
  for (int k = 0; k < n; k += std::max(1, n / 200)) {
    std::vector<int> near;
    double low = INFINITY;
    double high = -INFINITY;
    for (int i = 0; i < n; ++i) {
      if ((q.row(i) - q.row(k)).cwiseAbs().maxCoeff() > kSamePlace) continue;
      near.push_back(i);
      low = std::min(low, own[i]);
      high = std::max(high, own[i]);
    }
    const bool wider = high - low > 1.02 * widest;
    const bool more = high - low > 0.98 * widest && near.size() > best.size();
    if (!wider && !more) continue;
    widest = std::max(widest, high - low);
    best = near;
  }
  const double range = own.maxCoeff() - own.minCoeff();
  if (widest < kSweepShare * range || best.size() < kFewestAtRest) return {};
  return best;
}

// Mean of `values` at the indices `over`; 0 if there are none.
double mean_over(const VectorXd& values, const std::vector<int>& over) {
  double sum = 0.0;
  for (const int k : over) sum += values[k];
  return over.empty() ? 0.0 : sum / static_cast<double>(over.size());
}

// Intersection of the line with the plane through `p` with the normal `n`.
Vector3d plane_intersection(const Line& line, const Vector3d& n, const Vector3d& p) {
  return line.point + line.direction * ((p - line.point).dot(n) / line.direction.dot(n));
}

// Derivatives of f(shared unknowns) by differences, (size of f x shared unknowns); nonzero only for the
// unknowns of `hinges`.
MatrixXd derivatives(const HingeBundle& bundle, const std::vector<int>& hinges,
                     const std::function<VectorXd(const VectorXd&)>& f) {
  VectorXd step = VectorXd::Zero(bundle.shared_size());
  MatrixXd J = MatrixXd::Zero(f(step).size(), bundle.shared_size());
  for (const int j : hinges) {
    for (int c = bundle.first_unknown(j); c < bundle.first_unknown(j) + 4; ++c) {
      step[c] = kStep;
      const VectorXd up = f(step);
      step[c] = -kStep;
      J.col(c) = (up - f(step)) / (2.0 * kStep);
      step[c] = 0.0;
    }
  }
  return J;
}

// Distance [m] of two lines, negative if the vector from a to b points against `side`; so it is smooth at zero.
double normal_distance(const Line& a, const Line& b, const Vector3d& side) {
  const Vector3d n = a.direction.cross(b.direction).normalized();
  const double d = (b.point - a.point).dot(n);
  return n.dot(side) < 0.0 ? -d : d;
}

// Vector [m] from line a to line b in the plane through `at` that is perpendicular to their mean direction.
Vector3d offset_in_plane(const Line& a, const Line& b, const Vector3d& at) {
  const double same = a.direction.dot(b.direction) < 0.0 ? -1.0 : 1.0;
  const Vector3d n = (a.direction + same * b.direction).normalized();
  return plane_intersection(b, n, at) - plane_intersection(a, n, at);
}

// Angle [rad] of two lines, 0 to pi/2.
double angle_between(const Line& a, const Line& b) {
  const double c = std::abs(a.direction.dot(b.direction));
  return std::atan2(a.direction.cross(b.direction).norm(), c);
}

}  // namespace

CalibratedAxis axis_result(const HingeBundle& bundle, const std::vector<RigidBody>& bodies,
                           int hinge) {
  const Hinge& h = bundle.hinge(hinge);
  CalibratedAxis out;
  out.closes_loop = bundle.closes_loop(hinge);
  out.loop_play = bundle.play(hinge);
  out.a = h.a < 0 ? "world" : bodies[h.a].name;
  out.b = bodies[h.b].name;
  out.wobble = h.axis.wobble;
  out.play = h.axis.play;
  const VectorXd own = bundle.angles(hinge);
  out.range = own.maxCoeff() - own.minCoeff();
  const std::vector<int> rest = frames_at_rest(bundle, hinge);
  out.frames = static_cast<int>(rest.size());
  const std::vector<int> above = bundle.path_from_root(hinge);
  VectorXd mean = VectorXd::Zero(bundle.tree().hinges.size());
  for (const int j : above) mean[j] = mean_over(bundle.angles(j), rest);
  // The line at the position where the joints above rested.
  const auto line_at = [&](const VectorXd& step, const VectorXd& angles) {
    Line line = bundle.line(hinge, step);
    for (auto j = above.rbegin(); j != above.rend(); ++j) {
      const Line axis = bundle.line(*j, step);
      line.direction = rotation_of(angles[*j] * axis.direction) * line.direction;
      line.point = rotated_about(axis, angles[*j], line.point);
    }
    return line;
  };
  const VectorXd none = VectorXd::Zero(bundle.shared_size());
  const Line line = line_at(none, mean);
  Vector3d markers = bundle.shape(h.b).rowwise().mean();
  for (auto j = above.rbegin(); j != above.rend(); ++j)
    markers = rotated_about(bundle.line(*j), mean[*j], markers);
  out.direction = line.direction;
  out.point = line.point + line.direction * (markers - line.point).dot(line.direction);
  Eigen::Matrix<double, 3, 2> plane;
  plane.col(0) = line.direction.unitOrthogonal();
  plane.col(1) = line.direction.cross(Vector3d(plane.col(0)));
  const auto errors = [&](const VectorXd& step, const VectorXd& angles) -> VectorXd {
    const Line moved = line_at(step, angles);
    VectorXd e(4);
    e.head<2>() = plane.transpose() * moved.direction;
    e.tail<2>() =
        plane.transpose() * (plane_intersection(moved, line.direction, out.point) - out.point);
    return e;
  };
  std::vector<int> path = above;
  path.push_back(hinge);
  const MatrixXd shared =
      derivatives(bundle, path, [&](const VectorXd& step) { return errors(step, mean); });
  MatrixXd by_angle = MatrixXd::Zero(4, mean.size());
  for (const int j : above) {
    VectorXd up = mean;
    VectorXd down = mean;
    up[j] += kStep;
    down[j] -= kStep;
    by_angle.col(j) = (errors(none, up) - errors(none, down)) / (2.0 * kStep);
  }
  const MatrixXd C = bundle.covariance(shared, by_angle, rest);
  out.radius_angle = error_radius(C.topLeftCorner<2, 2>(), bundle.degrees_of_freedom());
  out.radius = error_radius(C.bottomRightCorner<2, 2>(), bundle.degrees_of_freedom());
  return out;
}

CalibratedLink link_result(const HingeBundle& bundle, int first, int second, int body) {
  CalibratedLink out;
  const Line a = bundle.line(first);
  const Line b = bundle.line(second);
  const Vector3d level =
      bundle.shape(body >= 0 ? body : bundle.hinge(second).b).rowwise().mean();
  const Vector3d normal = a.direction.cross(b.direction);
  const Vector3d across = offset_in_plane(a, b, level).normalized();
  const auto values = [&](const VectorXd& step) -> VectorXd {
    const Line la = bundle.line(first, step);
    const Line lb = bundle.line(second, step);
    VectorXd v(3);
    v << normal_distance(la, lb, normal), offset_in_plane(la, lb, level).dot(across),
        angle_between(la, lb);
    return v;
  };
  const VectorXd at = values(VectorXd::Zero(bundle.shared_size()));
  const MatrixXd J = derivatives(bundle, {first, second}, values);
  const MatrixXd C = bundle.covariance(J, MatrixXd::Zero(3, 0), {});
  const double dof = bundle.degrees_of_freedom();
  out.twist = at[2];
  out.twist_half_width = half_width(C(2, 2), dof);
  out.distance = std::abs(at[0]);
  out.distance_half_width = half_width(C(0, 0), dof);
  out.plane_parallel_distance = std::abs(at[1]);
  out.plane_half_width = half_width(C(1, 1), dof);
  if (out.twist < std::max(kParallel, out.twist_half_width)) {
    out.distance = out.plane_parallel_distance;
    out.distance_half_width = out.plane_half_width;
  } else if (out.twist > kSharePlane) {
    out.plane_parallel_distance = out.distance;
    out.plane_half_width = out.distance_half_width;
  }
  return out;
}

}  // namespace veridyn::internal
