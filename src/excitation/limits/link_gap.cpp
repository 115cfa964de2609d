#include "excitation/limits/link_gap.hpp"

#include <algorithm>
#include <cmath>

#include "math/numbers.hpp"
#include "math/random_numbers.hpp"
#include "model/moving_frame.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr int kPostures = 1000;        // number of random postures to find links that always touch
// Share of postures above which a touching pair counts as two parts of one joint: links that a joint connects
// overlap in all postures, others only in some.
constexpr double kTouchesAlways = 0.9;
constexpr double kStands = 1e-9;       // [m] largest change of a gap by rounding, if no joint affects it
constexpr int kSections = 60;          // steps of the search along a capsule's axis; each reduces the interval to 0.618 of its length
constexpr double kGoldenSection = 0.6180339887498949;

double within_one(double share) {
  return std::clamp(share, 0.0, 1.0);
}

// Shares s, t along two segments at which they are closest. The squared distance is convex, so that its
// minimum is at the stationary point or on an edge of the square [0, 1] x [0, 1].
std::pair<double, double> nearest_shares(const Eigen::Vector3d& a, const Eigen::Vector3d& along_a,
                                         const Eigen::Vector3d& b, const Eigen::Vector3d& along_b) {
  const Eigen::Vector3d apart = a - b;
  const double aa = along_a.squaredNorm(), bb = along_b.squaredNorm(), ab = along_a.dot(along_b);
  const double ra = along_a.dot(apart), rb = along_b.dot(apart);
  const double determinant = aa * bb - ab * ab;
  if (determinant > 1e-12 * aa * bb) {
    const double s = (ab * rb - bb * ra) / determinant;
    const double t = (aa * rb - ab * ra) / determinant;
    if (s >= 0.0 && s <= 1.0 && t >= 0.0 && t <= 1.0) return {s, t};
  }
  const auto s_for = [&](double t) { return aa > 0.0 ? within_one((t * ab - ra) / aa) : 0.0; };
  const auto t_for = [&](double s) { return bb > 0.0 ? within_one((s * ab + rb) / bb) : 0.0; };
  const std::pair<double, double> edges[] = {{0.0, t_for(0.0)}, {1.0, t_for(1.0)}, {s_for(0.0), 0.0}, {s_for(1.0), 1.0}};
  const auto distance = [&](const std::pair<double, double>& at) {
    return (apart + at.first * along_a - at.second * along_b).squaredNorm();
  };
  return *std::min_element(std::begin(edges), std::end(edges),
                           [&](const auto& x, const auto& y) { return distance(x) < distance(y); });
}

// Distance of a point from a box, negative inside, and the direction in which it increases.
double distance_to_box(const Obstacle& box, const Eigen::Vector3d& p, Eigen::Vector3d* direction) {
  const Eigen::Vector3d below = box.lower - p, above = p - box.upper;
  const Eigen::Vector3d beyond = below.cwiseMax(above);
  if (beyond.maxCoeff() <= 0.0) {
    Eigen::Index axis = 0;
    const double depth = beyond.maxCoeff(&axis);
    if (direction != nullptr) *direction = (below[axis] > above[axis] ? -1.0 : 1.0) * Eigen::Vector3d::Unit(axis);
    return depth;
  }
  Eigen::Vector3d way = beyond.cwiseMax(0.0);
  for (int axis = 0; axis < 3; ++axis)
    if (below[axis] > above[axis]) way[axis] = -way[axis];
  if (direction != nullptr) *direction = way.normalized();
  return way.norm();
}

// The frame of a capsule; nullopt: the world.
std::optional<FrameIndex> frame_of(const Model& arm, const Capsule& capsule) {
  if (capsule.frame == "world") return std::nullopt;
  const std::optional<FrameIndex> frame = arm.find_frame(capsule.frame);
  require(frame.has_value(), "excitation: found a shape on the frame '",
          capsule.frame, "', which '", arm.name(), "' does not have.");
  return frame;
}

struct RigidBody {
  std::optional<FrameIndex> mover;
  std::string name;
  std::vector<Capsule> capsules;
};

std::vector<RigidBody> rigid_bodies(const Model& arm, const std::vector<Capsule>& shapes) {
  std::vector<RigidBody> out;
  for (const Capsule& capsule : shapes) {
    const std::optional<FrameIndex> mover = moving_frame(arm, frame_of(arm, capsule));
    const auto own = std::find_if(out.begin(), out.end(), [&](const RigidBody& b) { return b.mover == mover; });
    if (own != out.end()) {
      own->capsules.push_back(capsule);
    } else {
      out.push_back({mover, capsule.frame, {capsule}});
    }
  }
  return out;
}

bool joined_by_one_joint(const Model& arm, std::optional<FrameIndex> a, std::optional<FrameIndex> b) {
  const auto hangs_on = [&](std::optional<FrameIndex> mover, std::optional<FrameIndex> other) {
    return mover && moving_frame(arm, arm.frames()[mover->value].parent) == other;
  };
  return hangs_on(a, b) || hangs_on(b, a);
}

// True for a link that turns on its mount: the obstacle overlaps the round end of its capsule, but not the
// axis.
bool touches_mount(const CollisionPair& pair, double gap) {
  double thinnest = kInfinity;
  for (const Capsule& capsule : pair.capsules) thinnest = std::min(thinnest, capsule.radius);
  return gap < pair.clearance && gap > -thinnest - kStands;
}

VectorXd random_posture(const Model& arm, RandomNumbers& random) {
  VectorXd q(arm.joints());
  for (int i = 0; i < arm.joints(); ++i) {
    const Limits& limits = arm.coordinates()[i].limits;
    const double lower = std::isfinite(limits.lower) ? limits.lower : -M_PI;
    const double upper = std::isfinite(limits.upper) ? limits.upper : M_PI;
    q[i] = random.uniform(lower, upper);
  }
  return q;
}

}  // namespace

LinkGap::Rod LinkGap::rod_of(const Model& arm, const Capsule& capsule) {
  return {frame_of(arm, capsule), capsule.from, capsule.to, capsule.radius};
}

LinkGap::LinkGap(const Model& arm, const CollisionPair& pair) : obstacle_(pair.obstacle) {
  for (const Capsule& capsule : pair.capsules) first_.push_back(rod_of(arm, capsule));
  for (const Capsule& capsule : pair.others) second_.push_back(rod_of(arm, capsule));
}

LinkGap::Nearest LinkGap::nearest(const FramePoints& at) const {
  Nearest best;
  best.gap = kInfinity;
  for (const Rod& a : first_) {
    const Eigen::Vector3d from = at.point(a.frame, a.from);
    const Eigen::Vector3d along = at.point(a.frame, a.to) - from;
    if (obstacle_) {
      // The distance from a convex body is convex along the axis: a golden section finds its minimum.
      double low = 0.0, high = 1.0;
      for (int k = 0; k < kSections && along.squaredNorm() > 0.0; ++k) {
        const double left = high - kGoldenSection * (high - low), right = low + kGoldenSection * (high - low);
        const bool go_left = distance_to_box(*obstacle_, from + left * along, nullptr) < distance_to_box(*obstacle_, from + right * along, nullptr);
        (go_left ? high : low) = go_left ? right : left;
      }
      for (const double s : {0.0, 0.5 * (low + high), 1.0}) {
        Eigen::Vector3d direction;
        const double gap = distance_to_box(*obstacle_, from + s * along, &direction) - a.radius;
        if (gap < best.gap) best = {gap, direction, a.frame, a.from + s * (a.to - a.from), {}};
      }
    }
    for (const Rod& b : second_) {
      const Eigen::Vector3d other = at.point(b.frame, b.from);
      const Eigen::Vector3d other_along = at.point(b.frame, b.to) - other;
      const auto [s, t] = nearest_shares(from, along, other, other_along);
      const Eigen::Vector3d way = from + s * along - other - t * other_along;
      const double distance = std::max(way.norm(), 1e-9);
      const double gap = distance - a.radius - b.radius;
      if (gap < best.gap)
        best = {gap, way / distance, a.frame, a.from + s * (a.to - a.from), b.frame, b.from + t * (b.to - b.from)};
    }
  }
  return best;
}

CollisionLimits collision_limits(const Model& arm, const std::vector<Capsule>& shapes,
                                 const std::vector<Obstacle>& obstacles, double clearance) {
  for (const Obstacle& o : obstacles)
    require((o.lower.array() < o.upper.array()).all(), "excitation: found the obstacle '", o.name,
            "' with a lower bound that is not below its upper one.");
  const std::vector<RigidBody> bodies = rigid_bodies(arm, shapes);
  std::vector<CollisionPair> asked;
  for (size_t a = 0; a < bodies.size(); ++a) {
    for (size_t b = a + 1; b < bodies.size(); ++b) {
      if (joined_by_one_joint(arm, bodies[a].mover, bodies[b].mover)) continue;
      asked.push_back({bodies[a].name, bodies[b].name, bodies[a].capsules, bodies[b].capsules, {}, clearance});
    }
    if (!bodies[a].mover) continue;
    for (const Obstacle& o : obstacles) asked.push_back({bodies[a].name, o.name, bodies[a].capsules, {}, o, clearance});
  }
  std::vector<LinkGap> gaps;
  for (const CollisionPair& pair : asked) gaps.emplace_back(arm, pair);
  std::vector<int> touches(asked.size(), 0);
  std::vector<double> least(asked.size(), kInfinity), largest(asked.size(), -kInfinity);
  FramePoints at(arm);
  RandomNumbers random(1, 0);
  for (int k = 0; k < kPostures; ++k) {
    at.move_to(random_posture(arm, random));
    for (size_t p = 0; p < gaps.size(); ++p) {
      const double gap = gaps[p].nearest(at).gap;
      if (gap < clearance) ++touches[p];
      least[p] = std::min(least[p], gap);
      largest[p] = std::max(largest[p], gap);
    }
  }
  CollisionLimits out;
  out.shapes = shapes;
  out.obstacles = obstacles;
  for (size_t p = 0; p < asked.size(); ++p) {
    const std::string name = asked[p].first + " and " + asked[p].second;
    const bool still = largest[p] - least[p] < kStands;  // no joint moves one of the two relative to the other
    if (asked[p].obstacle ? still && touches_mount(asked[p], largest[p]) : touches[p] > kTouchesAlways * kPostures) {
      out.touching.push_back(name);
      continue;
    }
    if (asked[p].obstacle && touches[p] == kPostures) out.impossible.push_back(name);
    out.pairs.push_back(std::move(asked[p]));
  }
  return out;
}

}  // namespace veridyn
