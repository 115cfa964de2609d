#include "excitation/cautions.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "excitation/excitation_numbers.hpp"
#include "excitation/limits/frame_points.hpp"
#include "kinematics/motion_limits.hpp"
#include "excitation/limits/link_gap.hpp"
#include "model/moving_frame.hpp"
#include "model/suggestion.hpp"
#include "veridyn/effects/effect_facts.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

// Names of the coordinates for which `lacks` is true: the file does not give the limit.
template <typename Lacks>
std::vector<std::string> missing_data_cautions(const Model& arm, const Lacks& lacks) {
  std::vector<std::string> out;
  for (const Coordinate& c : arm.coordinates()) {
    if (lacks(c)) out.push_back(c.name);
  }
  return out;
}

// The links that move and have a body but no shape, if other links have shapes.
std::vector<std::string> without_shape(const Model& arm, const std::vector<Capsule>& shapes) {
  std::vector<std::string> out;
  for (const FrameIndex k : arm.bodies()) {
    const std::optional<FrameIndex> mover = moving_frame(arm, k);
    const bool has = std::any_of(shapes.begin(), shapes.end(), [&](const Capsule& capsule) {
      const std::optional<FrameIndex> other = arm.find_frame(capsule.frame);
      return other && moving_frame(arm, other) == mover;
    });
    if (mover && !has) out.push_back(arm.frames()[k.value].name);
  }
  return out;
}

bool has_friction_values(const Model& arm) {
  return std::any_of(arm.effects().begin(), arm.effects().end(), [&](const EffectTerm& term) {
    if (!has_axis_effect(term.effect)) return false;
    const EffectFacts effect(arm, term);
    return effect.traits().role == EffectRole::kFriction && effect.has_values();
  });
}

constexpr ExcitationNumbers kNumbers;

// The larger end of a revolute joint's range [rad]; 0 if the file gives none.
double most_turned(const Coordinate& c) {
  double most = 0.0;
  for (const double end : {c.limits.lower, c.limits.upper})
    if (!c.prismatic && std::isfinite(end)) most = std::max(most, std::abs(end));
  return most;
}

// Warns of limits that are probably not in radians, in one sentence for ranges and one for speeds.
std::vector<std::string> degrees_cautions(const Model& arm) {
  std::vector<std::string> ranges, speeds, out;
  for (const Coordinate& c : arm.coordinates()) {
    if (most_turned(c) > kNumbers.most_turned) ranges.push_back(fmt::format("{} ({:.4g} to {:.4g})", c.name, c.limits.lower, c.limits.upper));
    if (!c.prismatic && std::isfinite(c.limits.velocity) && c.limits.velocity > kNumbers.fastest)
      speeds.push_back(fmt::format("{} ({:.4g})", c.name, c.limits.velocity));
  }
  if (!ranges.empty())
    out.push_back("ASSUMED: rad, though that would be more than two turns (are these degrees?), for the ranges of " + listed(ranges));
  if (!speeds.empty())
    out.push_back("ASSUMED: rad/s, though few arms are as fast (are these degrees per second?), for the speed limits of " + listed(speeds));
  return out;
}

}  // namespace

void require_ranges_in_radians(const Model& arm, const std::string& robot) {
  std::vector<std::string> turning;
  for (const Coordinate& c : arm.coordinates()) {
    if (c.prismatic) continue;
    const double most = most_turned(c);
    if (most <= kNumbers.most_turned || most > kNumbers.most_degrees) return;
    turning.push_back(fmt::format("{} {:.4g} to {:.4g}", c.name, c.limits.lower, c.limits.upper));
  }
  require(turning.size() < kNumbers.fewest_joints, robot, ": found the ranges ", listed(turning),
          ", all beyond two turns if they are in rad; expected rad, and these look like degrees.");
}

LowestPoint lowest_point(const Model& arm, const std::vector<Capsule>& shapes, const MotionSamples& motion) {
  LowestPoint out;
  FramePoints at(arm);
  const auto look = [&](FrameIndex frame, const Eigen::Vector3d& point, double radius) {
    const double z = at.point(frame, point).z() - radius;
    if (!(z >= out.z)) out = {z, arm.frames()[frame.value].name};
  };
  const auto moves = [&](FrameIndex frame) { return moving_frame(arm, frame).has_value(); };
  const int frames = static_cast<int>(arm.frames().size());
  for (Eigen::Index row = 0; row < motion.rows(); ++row) {
    at.move_to(motion.q.row(row).transpose());
    for (const Capsule& capsule : shapes) {
      const std::optional<FrameIndex> frame = arm.find_frame(capsule.frame);
      if (!frame || !moves(*frame)) continue;
      look(*frame, capsule.from, capsule.radius);
      look(*frame, capsule.to, capsule.radius);
    }
    for (int k = 0; k < frames; ++k) {
      if (moves({k})) look({k}, Eigen::Vector3d::Zero(), 0.0);
    }
  }
  return out;
}

std::vector<std::string> cautions(const Model& arm, const ExcitationOptions& options, const LowestPoint& lowest,
                                  const std::optional<Model>& powered) {
  std::vector<std::string> out;
  const CollisionLimits& kept = options.workspace.collisions;
  const std::string where = fmt::format("the lowest point of the motion is at z = {:.3g} m ({})", lowest.z, lowest.frame);
  if (kept.shapes.empty()) {
    out.push_back("NOT CHECKED: neither the floor nor self-collision, for the links have no shapes here; " + where +
                  ". --link-radius 0.05 --floor Z keeps links of that radius apart and above Z");
  } else {
    if (kept.obstacles.empty()) out.push_back("NOT CHECKED: the floor; " + where + ". --floor Z keeps the links above it");
    const std::vector<std::string> bare = without_shape(arm, kept.shapes);
    if (!bare.empty())
      out.push_back("NOT CHECKED: collisions of " + listed(bare) + ", for which no shape is known (--link-radius gives all links one)");
  }
  if (!kept.touching.empty())
    out.push_back("NOT KEPT APART, since their shapes touch whatever the joints do: " + listed(kept.touching));
  const std::vector<std::string> degrees = degrees_cautions(arm);
  out.insert(out.end(), degrees.begin(), degrees.end());
  const MotionLimits assumed = motion_limits(arm);
  for (int i = 0; i < arm.joints(); ++i) {
    const Coordinate& c = arm.coordinates()[i];
    if (!std::isfinite(c.limits.lower) || !std::isfinite(c.limits.upper))
      out.push_back(fmt::format("ASSUMED: a range of {:.3g} to {:.3g} {} for {}, of which the robot file gives no end (missing)",
                                assumed.lower[i], assumed.upper[i], position_unit(c), c.name));
  }
  const std::vector<std::string> speeds = missing_data_cautions(arm, [](const Coordinate& c) { return !std::isfinite(c.limits.velocity); });
  if (!speeds.empty())
    out.push_back("ASSUMED: at most 2 rad/s (0.2 m/s of a slide) for " + listed(speeds) +
                  ", of which the robot file gives no speed limit (missing, 0 or negative)");
  if (!powered) {
    out.push_back("NOT CHECKED: torques, for the bodies have no values (--model M.yaml gives them)");
    return out;
  }
  const std::vector<std::string> efforts = missing_data_cautions(*powered, [](const Coordinate& c) { return !std::isfinite(c.limits.effort); });
  if (!efforts.empty())
    out.push_back("NOT LIMITED: torques of " + listed(efforts) + ", of which the robot file gives no effort limit (missing, 0 or negative)");
  if (efforts.size() < arm.coordinates().size() && !has_friction_values(*powered))
    out.push_back("Torques are those of the bodies alone, for the model has no values of friction: real ones are larger "
                  "(--model with an identified model has it)");
  return out;
}

}  // namespace veridyn
