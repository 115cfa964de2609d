#include "rigid_bodies.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "deviations.hpp"
#include "veridyn/math/median.hpp"
#include "veridyn/math/numbers.hpp"

namespace veridyn::internal {
namespace {

constexpr double kFar = 6.0;           // standard deviations, beyond which a distance does not fit
constexpr double kFewestNoise = 2e-6;  // [m] lower bound of the noise
constexpr double kNarrow = 0.02;       // width per extent below which markers count as collinear
constexpr std::size_t kMostPermuted = 5;

class BodyFit {
 public:
  BodyFit(MarkerCapture& capture, RigidBody& body) : capture_(capture), body_(body) {}

  void fit() {
    const auto m = static_cast<Eigen::Index>(body_.markers.size());
    const Eigen::Index frames = capture_.time.size();
    body_.seen.assign(static_cast<std::size_t>(frames), 0);
    body_.pose.assign(static_cast<std::size_t>(frames), Eigen::Isometry3d::Identity());
    if (m < 3) {
      body_.fault = fmt::format("body '{}' has {} marker{}, and a pose needs three or more",
                                body_.name, m, m == 1 ? "" : "s");
      return;
    }
    if (!estimate_distances()) return;
    estimate_shape();
    if (!body_.fault.empty()) return;
    for (Eigen::Index k = 0; k < frames; ++k) process_frame(k);
    align_with_first_frame();
  }

 private:
  using Point = Eigen::Vector3d;

  // Reference to a marker's position [m] at one frame.
  MatrixXd::ColXpr position(Eigen::Index marker, Eigen::Index frame) {
    MatrixXd& path =
        capture_.markers[body_.markers[marker]]
            .position;
    return path.col(frame);
  }

  // Sets distances and noise from the frames that show both markers; false, and a fault: fewer than three do.
  bool estimate_distances() {
    const auto m = static_cast<Eigen::Index>(body_.markers.size());
    distances_ = MatrixXd::Zero(m, m);
    std::vector<double> deviations;
    for (Eigen::Index a = 0; a < m; ++a) {
      for (Eigen::Index b = 0; b < a; ++b) {
        std::vector<double> d;
        for (Eigen::Index k = 0; k < capture_.time.size(); ++k) {
          const double one = (position(a, k) - position(b, k)).norm();
          if (std::isfinite(one)) d.push_back(one);
        }
        if (d.size() < 3) {
          body_.fault = fmt::format(
              "markers '{}' and '{}' of body '{}' are seen together in {} frames, and three are "
              "needed",
              name(b), name(a), body_.name, d.size());
          return false;
        }
        const double middle = median(d);
        distances_(a, b) = distances_(b, a) = middle;
        for (const double one : d) deviations.push_back(one - middle);
      }
    }
    body_.extent = distances_.maxCoeff();
    // A distance varies with the noise of two markers along it.
    noise_ = std::max(kFewestNoise, robust_deviation(deviations) / std::sqrt(2.0));
    return true;
  }

  std::string name(Eigen::Index marker) const {
    return capture_.markers[
                                body_.markers[marker]]
        .name;
  }

  // Coordinates from distances: Torgerson, Psychometrika 17, 1952.
  void estimate_shape() {
    const Eigen::Index m = distances_.rows();
    const MatrixXd centre = MatrixXd::Identity(m, m) - MatrixXd::Constant(m, m, 1.0 / double(m));
    const MatrixXd G = -0.5 * centre * distances_.cwiseAbs2() * centre;
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(G);
    body_.shape = MatrixXd::Zero(3, m);
    for (int c = 0; c < 3; ++c) {
      const double value = std::max(0.0, eigen.eigenvalues()[m - 1 - c]);
      body_.shape.row(c) = std::sqrt(value) * eigen.eigenvectors().col(m - 1 - c).transpose();
    }
    body_.breadth = std::sqrt(body_.shape.bottomRows<2>().squaredNorm() / static_cast<double>(m));
    if (body_.breadth < std::max(kNarrow * body_.extent, 4.0 * noise_)) {
      body_.fault = fmt::format(
          "the markers of body '{}' are collinear: {:.2g} mm from one line, {:.3g} mm apart along "
          "it; its turns about that line cannot be seen, and one marker beside it is missing",
          body_.name, 1e3 * body_.breadth, 1e3 * body_.extent);
      return;
    }
    if (m > 3) choose_mirror_image();
  }

  // Distances do not distinguish a shape from its mirror image, which the first frame does.
  void choose_mirror_image() {
    double error[2] = {0.0, 0.0};
    MatrixXd mirrored = body_.shape;
    mirrored.row(2) *= -1.0;
    for (Eigen::Index k = 0; k < capture_.time.size(); ++k) {
      const MatrixXd seen = positions(k);
      if (!seen.allFinite()) continue;
      for (int side = 0; side < 2; ++side) {
        const MatrixXd& shape = side == 0 ? body_.shape : mirrored;
        const Eigen::Isometry3d T = fitted_pose(shape, seen);
        const MatrixXd moved = (T.linear() * shape).colwise() + Point(T.translation());
        error[side] += (moved - seen).norm();
      }
    }
    if (error[1] < error[0]) body_.shape = mirrored;
  }

  MatrixXd positions(Eigen::Index frame) {
    const auto m = static_cast<Eigen::Index>(body_.markers.size());
    MatrixXd out(3, m);
    for (Eigen::Index a = 0; a < m; ++a) out.col(a) = position(a, frame);
    return out;
  }

  // Largest deviation of the distances, in standard deviations, if marker which[k] is called names[k].
  double name_misfit(const MatrixXd& seen, const std::vector<int>& names,
                const std::vector<int>& which) const {
    double worst = 0.0;
    for (std::size_t a = 0; a < which.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) {
        const double d = (seen.col(which[a]) - seen.col(which[b])).norm();
        worst = std::max(worst, std::abs(d - distances_(names[a], names[b])));
      }
    }
    return worst / (std::sqrt(2.0) * noise_);
  }

  // Processes one frame: restores swapped names, drops positions that do not fit, fits the pose to
  // the rest.
  void process_frame(Eigen::Index frame) {
    MatrixXd seen = positions(frame);
    std::vector<int> which;
    for (int a = 0; a < seen.cols(); ++a) {
      if (seen.col(a).allFinite()) which.push_back(a);
    }
    if (which.size() >= 2 && name_misfit(seen, which, which) > kFar) {
      if (!restore_swapped_names(seen, which)) which = consistent_markers(seen, which);
      for (int a = 0; a < seen.cols(); ++a) {
        const bool kept = std::find(which.begin(), which.end(), a) != which.end();
        if (!kept && seen.col(a).allFinite()) {
          ++body_.outliers;
          seen.col(a).setConstant(kNaN);
        }
        position(a, frame) = seen.col(a);
      }
    }
    if (which.size() < 3) return;
    MatrixXd from(3, static_cast<Eigen::Index>(which.size()));
    MatrixXd to = from;
    for (std::size_t a = 0; a < which.size(); ++a) {
      from.col(a) = body_.shape.col(which[a]);
      to.col(a) = seen.col(which[a]);
    }
    body_.pose[frame] = fitted_pose(from, to);
    body_.seen[frame] = 1;
  }

  // True if another order of the names fits the distances; the columns of `seen` are then reordered.
  bool restore_swapped_names(MatrixXd& seen, const std::vector<int>& which) {
    if (which.size() < 3 || which.size() > kMostPermuted) return false;
    std::vector<int> names = which;
    std::vector<int> best;
    double least = 0.5 * kFar;
    while (std::next_permutation(names.begin(), names.end())) {
      const double one = name_misfit(seen, names, which);
      if (one >= least) continue;
      least = one;
      best = names;
    }
    if (best.empty()) return false;
    const MatrixXd old = seen;
    for (std::size_t a = 0; a < which.size(); ++a) seen.col(best[a]) = old.col(which[a]);
    ++body_.relabelled;
    return true;
  }

  // The largest set of markers with consistent distances; empty if only one pair is consistent, which is not
  // sufficient.
  std::vector<int> consistent_markers(const MatrixXd& seen, std::vector<int> which) const {
    while (which.size() > 2 && name_misfit(seen, which, which) > kFar) {
      std::size_t best = 0;
      double least = std::numeric_limits<double>::infinity();
      for (std::size_t k = 0; k < which.size(); ++k) {
        std::vector<int> rest = which;
        rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(k));
        const double one = name_misfit(seen, rest, rest);
        if (one >= least) continue;
        least = one;
        best = k;
      }
      which.erase(which.begin() + static_cast<std::ptrdiff_t>(best));
    }
    if (name_misfit(seen, which, which) > kFar) which.clear();
    return which;
  }

  // Centres the shape and rotates it to the cameras' axes at the first frame that shows it;
  // estimates the noise from the residuals.
  void align_with_first_frame() {
    const auto first = std::find(body_.seen.begin(), body_.seen.end(), 1);
    if (first == body_.seen.end()) {
      body_.fault = fmt::format("body '{}' never shows three markers at once", body_.name);
      return;
    }
    const Eigen::Matrix3d R =
        body_.pose[first - body_.seen.begin()].linear();
    body_.shape = (R * body_.shape).eval();
    std::vector<double> left;
    double used = 0.0;
    for (std::size_t k = 0; k < body_.pose.size(); ++k) {
      if (body_.seen[k] == 0) continue;
      body_.pose[k].linear() = (body_.pose[k].linear() * R.transpose()).eval();
      const MatrixXd seen = positions(static_cast<Eigen::Index>(k));
      for (Eigen::Index a = 0; a < seen.cols(); ++a) {
        if (!seen.col(a).allFinite()) continue;
        const Point r = seen.col(a) - body_.pose[k] * Point(body_.shape.col(a));
        left.insert(left.end(), {r.x(), r.y(), r.z()});
      }
      used += 6.0;
    }
    const double share = 1.0 - used / static_cast<double>(left.size());
    body_.noise =
        std::max(kFewestNoise, robust_deviation(left) / std::sqrt(std::max(0.1, share)));
  }

  MarkerCapture& capture_;
  RigidBody& body_;
  MatrixXd distances_;
  double noise_ = 0.0;
};

}  // namespace

std::vector<RigidBody> rigid_bodies(MarkerCapture& capture) {
  std::vector<RigidBody> bodies;
  for (const std::string& name : capture.bodies()) {
    RigidBody body;
    body.name = name;
    for (std::size_t k = 0; k < capture.markers.size(); ++k) {
      if (capture.markers[k].body == name) body.markers.push_back(static_cast<int>(k));
    }
    BodyFit(capture, body).fit();
    bodies.push_back(std::move(body));
  }
  return bodies;
}

}  // namespace veridyn::internal
