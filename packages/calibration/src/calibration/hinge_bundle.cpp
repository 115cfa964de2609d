#include "hinge_bundle.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "deviations.hpp"

namespace veridyn::internal {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kHuber = 2.5;      // standard deviations of a position's residual
constexpr int kRounds = 3;          // fits without outliers, each with the last one's noise
constexpr double kLeast = 2e-7;     // [m] lower bound of the noise

std::size_t at(int k) {
  return static_cast<std::size_t>(k);
}

}  // namespace

HingeBundle::HingeBundle(const MarkerCapture& capture, const std::vector<RigidBody>& bodies,
                         const HingeTree& tree, const AxesOptions& options)
    : capture_(capture), bodies_(bodies), tree_(tree), options_(options) {
  choose_frames();
  if (!ready()) return;
  set_initial_values();
  add_markers();
  add_closures();
}

// Selects frames that show two markers of each body, and three of a moving root; the first one with
// a pose of every body is the reference.
void HingeBundle::choose_frames() {
  std::vector<int> good;
  int reference = -1;
  for (int k = 0; k < static_cast<int>(capture_.time.size()); ++k) {
    bool enough = true;
    bool all = true;
    for (const int body : tree_.bodies) {
      const RigidBody& b = bodies_[at(body)];
      int visible = 0;
      for (const int m : b.markers) visible += capture_.markers[at(m)].position.col(k).allFinite();
      enough = enough && visible >= (body == tree_.root && !tree_.root_rests ? 3 : 2);
      all = all && b.seen[at(k)] != 0;
    }
    if (!enough) continue;
    if (all && reference < 0) reference = k;
    good.push_back(k);
  }
  if (reference < 0 || static_cast<int>(good.size()) < options_.fewest_frames) {
    reason_ = fmt::format("too few frames show all bodies of the chain ({}{}), and {} or more are "
                          "needed", good.size(),
                          reference < 0 ? ", none of them three markers of each" : "",
                          options_.fewest_frames);
    return;
  }
  frames_.push_back(reference);
  const auto count = static_cast<int>(good.size());
  const int used = std::min(count, options_.most_frames);
  for (int k = 0; k < used; ++k) {
    const int frame = good[at(static_cast<int>(static_cast<long>(k) * count / used))];
    if (frame != reference) frames_.push_back(frame);
  }
}

// Sets axes, angles and poses of the root from the closed forms.
void HingeBundle::set_initial_values() {
  const int reference = frames_.front();
  const auto moved = [&](int body, int frame) -> Isometry3d {
    if (body < 0 || (body == tree_.root && tree_.root_rests)) return Isometry3d::Identity();
    const RigidBody& b = bodies_[at(body)];
    return b.pose[at(frame)] * b.pose[at(reference)].inverse();
  };
  const auto seen = [&](int body, int frame) {
    return body < 0 || bodies_[at(body)].seen[at(frame)] != 0;
  };
  for (int j = 0; j < hinges(); ++j) {
    const Hinge& hinge = this->hinge(j);
    const Isometry3d T = hinge.a < 0 ? Isometry3d::Identity()
                                     : bodies_[at(hinge.a)].pose[at(reference)];
    const Line line{T.linear() * hinge.axis.in_a.direction, T * hinge.axis.in_a.point};
    start_.push_back(line);
    plane_.emplace_back();
    plane_.back().col(0) = line.direction.unitOrthogonal();
    plane_.back().col(1) = line.direction.cross(Vector3d(plane_.back().col(0)));
    hinge_unknown_.push_back(problem_.add_unknown(VectorXd::Zero(4)));
  }
  for (const int body : tree_.bodies) {
    const RigidBody& b = bodies_[at(body)];
    marker_unknown_.emplace_back();
    for (Eigen::Index m = 0; m < b.shape.cols(); ++m) {
      const Vector3d x = b.pose[at(reference)] * Vector3d(b.shape.col(m));
      marker_unknown_.back().push_back(problem_.add_unknown(x));
    }
  }
  const int free_root = tree_.root_rests ? 0 : 6;
  VectorXd last = VectorXd::Zero(free_root + static_cast<Eigen::Index>(tree_.hinges.size()));
  Isometry3d root = Isometry3d::Identity();
  for (const int frame : frames_) {
    if (!tree_.root_rests && seen(tree_.root, frame)) root = moved(tree_.root, frame);
    for (std::size_t j = 0; j < tree_.hinges.size(); ++j) {
      const Hinge& hinge = tree_.hinges[j];
      if (!seen(hinge.a, frame) || !seen(hinge.b, frame)) continue;  // keeps the previous angle
      const Isometry3d turn = moved(hinge.a, frame).inverse() * moved(hinge.b, frame);
      last[free_root + static_cast<Eigen::Index>(j)] =
          rotation_vector(turn.linear()).dot(start_[j].direction);
    }
    root_start_.push_back(root);
    const bool is_reference = frame_unknown_.empty();
    frame_unknown_.push_back(
        is_reference ? -1 : problem_.add_unknown(last, LeastSquares::Scope::kLocal));
  }
}

// Adds an unknown position for every marker and an observation for every frame that shows it.
void HingeBundle::add_markers() {
  std::vector<double> noises;
  for (const int body : tree_.bodies) noises.push_back(bodies_[at(body)].noise);
  std::sort(noises.begin(), noises.end());
  noise_ = std::max(kLeast, noises[noises.size() / 2]);
  for (int k = 0; k < frames(); ++k) {
    for (std::size_t b = 0; b < tree_.bodies.size(); ++b) {
      const RigidBody& body = bodies_[at(tree_.bodies[b])];
      for (std::size_t m = 0; m < body.markers.size(); ++m) {
        const auto position = capture_.markers[at(body.markers[m])].position.col(frames_[at(k)]);
        if (!position.allFinite()) continue;
        const Seen seen{k, static_cast<int>(b), static_cast<int>(m)};
        Observation o;
        o.size = 3;
        o.unknowns.push_back(marker_unknown_[b][m]);
        for (const int j : path(tree_.bodies[b])) o.unknowns.push_back(hinge_unknown_[at(j)]);
        if (frame_unknown_[at(k)] >= 0) o.unknowns.push_back(frame_unknown_[at(k)]);
        // A resting root has no unknowns per frame.
        if (tree_.root_rests && hinge_of(tree_.bodies[b]) < 0 && frame_unknown_[at(k)] >= 0)
          o.unknowns.pop_back();
        o.residual = residual(seen);
        o.loss = kHuber;
        problem_.add(std::move(o));
        seen_.push_back(seen);
      }
    }
  }
}

// The hinges with their initial lines and the root's pose at a used frame, without a marker.
HingePath HingeBundle::free_path(const std::vector<int>& hinges, int frame) const {
  HingePath path;
  path.hinges = hinges;
  for (const int j : path.hinges) {
    path.start.push_back(start_[at(j)]);
    path.plane.push_back(plane_[at(j)]);
  }
  path.root = root_start_[at(frame)];
  path.root_rests = tree_.root_rests;
  path.is_reference = frame == 0;
  path.local_size = (tree_.root_rests ? 0 : 6) + static_cast<int>(tree_.hinges.size());
  return path;
}

// Residual of one observed marker position over its noise.
Residual HingeBundle::residual(const Seen& seen) const {
  HingePath path = free_path(this->path(tree_.bodies[at(seen.body)]), seen.frame);
  const RigidBody& body = bodies_[at(tree_.bodies[at(seen.body)])];
  path.measured = capture_.markers[at(body.markers[at(seen.marker)])].position.col(
      frames_[at(seen.frame)]);
  const double* noise = &noise_;
  return [path = std::move(path), noise](const double* const* x, double* r, double* const* J) {
    path.evaluate(x, *noise, r, J);
  };
}

void HingeBundle::fit() {
  problem_.minimise(options_.threads, 30);
  if (!closed_.empty()) {
    // Play is estimated before outliers are excluded: in a loop closed too tightly correct positions are outliers.
    information_ = std::make_unique<Information>(problem_);
    estimate_play(Spread::kRobust);
  }
  for (int round = 0; round < kRounds; ++round) {
    reject_outliers();
    close_loops();
    problem_.minimise(options_.threads, 30);
  }
  estimate_uncertainty();
  if (closed_.empty() || !estimate_play(Spread::kMeanSquare)) return;
  close_loops();
  problem_.minimise(options_.threads, 30);
  estimate_uncertainty();
}

// Re-estimates the noise and deactivates the observations beyond options.outlier deviations.
void HingeBundle::reject_outliers() {
  std::vector<double> lengths;
  double locals = 0.0;
  for (std::size_t k = 0; k < seen_.size(); ++k)
    lengths.push_back(problem_.residual(problem_.observations()[k]).norm());
  for (const int u : frame_unknown_) {
    if (u >= 0) locals += static_cast<double>(problem_.value(u).size());
  }
  const double residuals = 3.0 * static_cast<double>(lengths.size());
  const double share = std::max(0.1, 1.0 - (locals + problem_.shared_size()) / residuals);
  const double deviation = robust_deviation_of_lengths(lengths) / std::sqrt(share);
  outliers_ = 0;
  for (std::size_t k = 0; k < lengths.size(); ++k) {
    Observation& o = problem_.observations()[k];
    o.active = lengths[k] <= options_.outlier * deviation;
    o.loss = 0.0;
    outliers_ += o.active ? 0 : 1;
  }
  noise_ = std::max(kLeast, noise_ * deviation);
}

// Computes the information matrix, the correlation of frames and the variance of the residuals.
void HingeBundle::estimate_uncertainty() {
  information_ = std::make_unique<Information>(problem_);
  double chi2 = 0.0;
  std::map<std::pair<int, int>, std::vector<std::vector<double>>> series;
  for (std::size_t k = 0; k < seen_.size(); ++k) {
    const Observation& o = problem_.observations()[k];
    if (!o.active) continue;
    const VectorXd r = problem_.residual(o);
    chi2 += r.squaredNorm();
    auto& three = series[{seen_[k].body, seen_[k].marker}];
    if (three.empty())
      three.assign(3, std::vector<double>(frames_.size(), std::nan("")));
    for (int c = 0; c < 3; ++c) three[at(c)][at(seen_[k].frame)] = r[c];
  }
  std::vector<std::vector<double>> all;
  for (auto& [key, three] : series) {
    for (std::vector<double>& one : three) all.push_back(std::move(one));
  }
  // Each pose was given as four markers: twelve coordinates for six degrees of freedom.
  correlation_ = correlation_factor(all);
  // Rows that close a loop have no noise of their own: they reduce the number of unknowns.
  double taken = 0.0;
  for (std::size_t k = 0; k < closed_.size(); ++k)
    taken += closure_leverage(problem_.observations()[seen_.size() + k], closed_[k].frame);
  const double rows = 1.0 * information_->residuals() - 6.0 * static_cast<double>(closed_.size());
  const double free = std::max(1.0, rows - (information_->unknowns() - taken));
  variance_ = chi2 / free * correlation_ * (capture_.from_poses ? 2.0 : 1.0);
  degrees_of_freedom_ = std::max(1.0, free / correlation_);
  noise_ *= std::sqrt(chi2 / free);
}

std::vector<double> HingeBundle::residuals() const {
  std::vector<double> out;
  for (std::size_t k = 0; k < seen_.size(); ++k) {
    const Observation& o = problem_.observations()[k];
    if (!o.active) continue;
    const VectorXd r = noise_ * problem_.residual(o);
    out.insert(out.end(), r.begin(), r.end());
  }
  return out;
}

// Hinge that joins a body to its parent; -1 for the root.
int HingeBundle::hinge_of(int body) const {
  for (std::size_t j = 0; j < tree_.hinges.size(); ++j) {
    if (tree_.hinges[j].b == body) return static_cast<int>(j);
  }
  return -1;
}

const Hinge& HingeBundle::hinge(int hinge) const {
  return closes_loop(hinge) ? tree_.closing[at(hinge) - tree_.hinges.size()]
                            : tree_.hinges[at(hinge)];
}

std::vector<int> HingeBundle::path(int body) const {
  std::vector<int> out;
  for (int j = hinge_of(body); j >= 0; j = hinge_of(tree_.hinges[at(j)].a))
    out.insert(out.begin(), j);
  return out;
}

std::vector<int> HingeBundle::path_from_root(int hinge) const {
  return path(this->hinge(hinge).a);
}

Line HingeBundle::line(int hinge, const VectorXd& step) const {
  VectorXd x = problem_.value(hinge_unknown_[at(hinge)]);
  if (step.size() > 0) x += step.segment(first_unknown(hinge), 4);
  return moved_line(start_[at(hinge)], plane_[at(hinge)], x.data());
}

int HingeBundle::first_unknown(int hinge) const {
  return problem_.shared_offset(hinge_unknown_[at(hinge)]);
}

MatrixXd HingeBundle::shape(int body) const {
  const auto found = std::find(tree_.bodies.begin(), tree_.bodies.end(), body);
  const auto& unknowns = marker_unknown_[at(static_cast<int>(found - tree_.bodies.begin()))];
  MatrixXd out(3, static_cast<Eigen::Index>(unknowns.size()));
  for (std::size_t m = 0; m < unknowns.size(); ++m)
    out.col(m) = problem_.value(unknowns[m]);
  return out;
}

VectorXd HingeBundle::angles(int hinge) const {
  VectorXd out = VectorXd::Zero(frames());
  if (closes_loop(hinge)) {
    const auto rotations = [&](int body) {
      std::vector<Eigen::Matrix3d> R(at(frames()), Eigen::Matrix3d::Identity());
      for (const int j : path(body)) {
        const VectorXd q = angles(j);
        for (int k = 0; k < frames(); ++k)
          R[at(k)] = R[at(k)] * rotation_of(q[k] * line(j).direction);
      }
      return R;
    };
    const auto a = rotations(this->hinge(hinge).a);
    const auto b = rotations(this->hinge(hinge).b);
    for (int k = 1; k < frames(); ++k)
      out[k] = rotation_vector(a[at(k)].transpose() * b[at(k)]).dot(line(hinge).direction);
    return out;
  }
  for (int k = 1; k < frames(); ++k)
    out[k] = problem_.value(frame_unknown_[at(k)])[(tree_.root_rests ? 0 : 6) + hinge];
  return out;
}

MatrixXd HingeBundle::covariance(const MatrixXd& shared, const MatrixXd& mean_angles,
                                 const std::vector<int>& over) const {
  std::map<int, MatrixXd> local;
  const int first = tree_.root_rests ? 0 : 6;
  for (const int k : over) {
    const int u = frame_unknown_[at(k)];
    if (u < 0) continue;
    MatrixXd g = MatrixXd::Zero(shared.rows(), problem_.value(u).size());
    g.middleCols(first, mean_angles.cols()) = mean_angles / static_cast<double>(over.size());
    local.emplace(u, std::move(g));
  }
  return variance_ * information_->covariance(shared, local);
}

}  // namespace veridyn::internal
