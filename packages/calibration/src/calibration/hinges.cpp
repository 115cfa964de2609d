#include "hinges.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "deviations.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/model/suggestion.hpp"

namespace veridyn::internal {
namespace {

constexpr double kDeviations = 4.0;  // multiple of the noise that a hinge's residual may reach
constexpr double kLooseTurn = 0.5 * kDegree; // allowed in addition to the noise: a real hinge has some play
constexpr double kLoosePlay = 0.001;         // [m] allowed in addition to the noise
constexpr double kStill = 4.0;  // standard deviations within which a body counts as resting

// A pair of bodies (-1: the cameras) with the axis that fits it best.
struct Candidate {
  int a, b;
  CommonAxis axis;
  std::string reason;  // reason if the pair is no hinge; empty if it is
};

// [rad] Standard deviation of the body's orientation about its narrowest direction.
double orientation_noise(const RigidBody& body) {
  return body.noise / std::max(1e-6, body.breadth);
}

// True if the body's farthest marker scatters by less than 4 deviations of its noise.
bool is_stationary(const RigidBody& body) {
  // Position noise of its farthest marker.
  Eigen::Index far = 0;
  body.shape.colwise().norm().maxCoeff(&far);
  std::vector<Eigen::Vector3d> at;
  for (std::size_t k = 0; k < body.pose.size(); ++k) {
    if (body.seen[k] != 0) at.emplace_back(body.pose[k] * Eigen::Vector3d(body.shape.col(far)));
  }
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& p : at) mean += p / static_cast<double>(at.size());
  double square = 0.0;
  for (const auto& p : at) square += (p - mean).squaredNorm() / static_cast<double>(at.size());
  return std::sqrt(square / 3.0) < kStill * body.noise;
}

class HingeFinder {
 public:
  HingeFinder(const std::vector<RigidBody>& bodies, const AxesOptions& options)
      : bodies_(bodies), options_(options) {}

  // Finds the common axis of two bodies; `reason` states why they are no hinge.
  Candidate examine_pair(int a, int b) const {
    Candidate c{a, b, {}, ""};
    const auto quoted = [](const std::string& body) {
      return body.empty() ? "the body" : "'" + body + "'";
    };
    const std::string names = quoted(name(a)) + " and " + quoted(name(b));
    for (const int k : {a, b}) {
      if (k >= 0 && !body(k).fault.empty()) c.reason = body(k).fault;
    }
    if (!c.reason.empty()) return c;
    Isometries T_a_b;
    double reach_a = 0.0;
    for (std::size_t k = 0; k < body(b).pose.size(); ++k) {
      if (body(b).seen[k] == 0 || (a >= 0 && body(a).seen[k] == 0)) continue;
      T_a_b.push_back(a < 0 ? body(b).pose[k] : body(a).pose[k].inverse() * body(b).pose[k]);
    }
    if (static_cast<int>(T_a_b.size()) < options_.fewest_frames) {
      c.reason = fmt::format("{}: too few frames show both ({}), and {} or more are needed", names,
                             T_a_b.size(), options_.fewest_frames);
      return c;
    }
    const RotationSpread spread = rotation_spread(T_a_b);
    const double swing = std::sqrt(spread.eigenvalues[1]) / kDegree;
    if (swing < options_.smallest_swing) {
      c.reason = fmt::format(
          "{}: they turn by {:.2g} deg rms against each other, which shows no axis; a sweep of the "
          "joint between them is missing", names, swing);
      return c;
    }
    c.axis = common_axis(T_a_b);
    reach_a = a < 0 ? 0.0 : c.axis.in_a.point.norm();
    const double noise_a = a < 0 ? 0.0 : orientation_noise(body(a));
    const double noise_b = orientation_noise(body(b));
    const double turn = kDeviations * std::hypot(noise_a, noise_b) + kLooseTurn;
    const double way = kDeviations * (std::hypot(noise_a * reach_a,
                                                 noise_b * c.axis.in_b.point.norm()) +
                                      2.0 * body(b).noise) + kLoosePlay;
    if (c.axis.wobble > turn || c.axis.play > way || c.axis.slide > way) {
      c.reason = fmt::format(
          "{}: they do not turn about one axis (the best one wobbles by {:.2g} deg, moves by "
          "{:.2g} mm and slides by {:.2g} mm rms); a body between them may be missing", names,
          c.axis.wobble / kDegree, 1e3 * c.axis.play, 1e3 * c.axis.slide);
    }
    return c;
  }

  const RigidBody& body(int k) const { return bodies_[k]; }
  std::string name(int k) const { return k < 0 ? "world" : body(k).name; }

  // Index of a body by name; -1: "world". Throws InvalidInput for another name.
  int index(const std::string& wanted) const {
    std::vector<std::string> names;
    for (std::size_t k = 0; k < bodies_.size(); ++k) {
      names.push_back(bodies_[k].name);
      if (bodies_[k].name == wanted) return static_cast<int>(k);
    }
    if (wanted == "world") return -1;
    throw InvalidInput(text("axis: found no body '", wanted, "'", did_you_mean(wanted, names),
                            ", expected one of ", listed(names), "."));
  }

 private:
  const std::vector<RigidBody>& bodies_;
  const AxesOptions& options_;
};

// Sets of connected bodies; -1 (world) is the last entry.
class Sets {
 public:
  explicit Sets(int bodies) : parent_(static_cast<std::size_t>(bodies) + 1) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  // Unites the sets of two bodies; false if they were one set already.
  bool join(int a, int b) {
    const int x = find(slot(a));
    const int y = find(slot(b));
    parent_[x] = y;
    return x != y;
  }
  bool same(int a, int b) { return find(slot(a)) == find(slot(b)); }

 private:
  int slot(int body) const { return body < 0 ? static_cast<int>(parent_.size()) - 1 : body; }
  int find(int x) {
    while (parent_[x] != x) x = parent_[x];
    return x;
  }
  std::vector<int> parent_;
};

// The tree of hinges that `edges` reach from the root, parents first.
HingeTree tree_from(int root, const std::vector<Candidate>& edges, const HingeFinder& hinge_finder) {
  HingeTree tree;
  tree.root = root;
  tree.root_rests = root < 0 || is_stationary(hinge_finder.body(root));
  if (root >= 0) tree.bodies.push_back(root);
  std::vector<char> used(edges.size(), 0);
  std::vector<int> reached = {root};
  for (std::size_t next = 0; next < reached.size(); ++next) {
    for (std::size_t k = 0; k < edges.size(); ++k) {
      const Candidate& e = edges[k];
      if (used[k] != 0 || (e.a != reached[next] && e.b != reached[next])) continue;
      used[k] = 1;
      Hinge hinge{e.a, e.b, e.axis};
      if (e.b == reached[next]) {
        std::swap(hinge.a, hinge.b);
        std::swap(hinge.axis.in_a, hinge.axis.in_b);
      }
      tree.hinges.push_back(hinge);
      tree.bodies.push_back(hinge.b);
      reached.push_back(hinge.b);
    }
  }
  return tree;
}

struct ChosenHinges {
  std::vector<Candidate> edges;    // chosen hinges; they form no loop
  std::vector<Candidate> closing;  // requested hinges that close a loop
};

bool joins_same_bodies(const Candidate& c, const Candidate& d) {
  return (c.a == d.a && c.b == d.b) || (c.a == d.b && c.b == d.a);
}

// The requested hinges, or nearest neighbours in the file first, without loops. A loop is closed only on
// request, since an axis found between its ends need not be a hinge: the far link of a parallelogram turns
// about a line of its base that carries no hinge.
ChosenHinges chosen_hinges(const HingeFinder& hinge_finder, int bodies, const AxesOptions& options,
                    std::vector<std::string>& cannot_tell) {
  ChosenHinges found;
  std::vector<Candidate>& edges = found.edges;
  Sets sets(bodies);
  const auto take = [&](const Candidate& c) {
    if (!c.reason.empty()) return;
    if (sets.join(c.a, c.b)) {
      edges.push_back(c);
      return;
    }
    const auto again = [&](const Candidate& d) { return joins_same_bodies(c, d); };
    if (std::none_of(edges.begin(), edges.end(), again) &&
        std::none_of(found.closing.begin(), found.closing.end(), again))
      found.closing.push_back(c);
  };
  for (const auto& [a, b] : options.between) {
    const Candidate c = hinge_finder.examine_pair(hinge_finder.index(a), hinge_finder.index(b));
    require(c.b >= 0, "axis: found 'world' as the second body, expected it as the first.");
    if (!c.reason.empty()) cannot_tell.push_back(c.reason);
    take(c);
  }
  if (!options.between.empty()) return found;
  if (bodies == 1) {
    const Candidate c = hinge_finder.examine_pair(-1, 0);
    if (!c.reason.empty()) cannot_tell.push_back(c.reason);
    take(c);
    return found;
  }
  std::vector<Candidate> refused;
  for (int gap = 1; gap < bodies; ++gap) {
    for (int a = 0; a + gap < bodies; ++a) {
      if (sets.same(a, a + gap)) continue;
      const Candidate c = hinge_finder.examine_pair(a, a + gap);
      take(c);
      if (!c.reason.empty() && gap == 1) refused.push_back(c);
    }
  }
  for (const Candidate& c : refused) {
    if (!sets.same(c.a, c.b) &&
        std::find(cannot_tell.begin(), cannot_tell.end(), c.reason) == cannot_tell.end())
      cannot_tell.push_back(c.reason);
  }
  return found;
}

}  // namespace

std::vector<HingeTree> find_hinge_trees(const std::vector<RigidBody>& bodies, const AxesOptions& options,
                                   std::vector<std::string>& cannot_tell) {
  const HingeFinder hinge_finder(bodies, options);
  const auto count = static_cast<int>(bodies.size());
  const ChosenHinges found = chosen_hinges(hinge_finder, count, options, cannot_tell);
  const std::vector<Candidate>& edges = found.edges;
  Sets sets(count);
  for (const Candidate& e : edges) sets.join(e.a, e.b);
  std::vector<HingeTree> trees;
  std::vector<char> done(edges.size(), 0);
  for (std::size_t k = 0; k < edges.size(); ++k) {
    if (done[k] != 0) continue;
    std::vector<Candidate> mine;
    std::optional<int> root;
    for (std::size_t other = k; other < edges.size(); ++other) {
      if (!sets.same(edges[k].a, edges[other].a)) continue;
      done[other] = 1;
      mine.push_back(edges[other]);
      for (const int body : {edges[other].a, edges[other].b}) {
        if (body < 0) root = body;
        if (!root && is_stationary(hinge_finder.body(body))) root = body;
      }
    }
    if (!root) {
      root = mine.front().a;
      for (const Candidate& e : mine) root = std::min({*root, e.a, e.b});
    }
    trees.push_back(tree_from(*root, mine, hinge_finder));
    for (const Candidate& c : found.closing) {
      if (sets.same(c.a, edges[k].a)) trees.back().closing.push_back({c.a, c.b, c.axis});
    }
  }
  return trees;
}

}  // namespace veridyn::internal
