#include "veridyn/control/tether_guard.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

using Eigen::Vector3d;

constexpr double kShortest = 1e-6;  // [m] smallest distance of tips with a defined direction
constexpr double kLearning = 0.01;  // share of the difference that the estimated unloaded length gains per period
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

}  // namespace

TetherGuard::TetherGuard(int arms, std::vector<Member> members, const TetherGuardOptions& options)
    : options_(options),
      members_(std::move(members)),
      lengths_(members_.size(), kUnknown),
      limits_(members_.size(), kUnknown),
      pushes_(members_.size(), 0),
      motions_(static_cast<std::size_t>(std::max(0, arms))),
      seen_(motions_.size()) {
  for (const double value :
       {options.period, options.margin, options.horizon, options.least_push, options.rest,
        options.acceleration, options.speed, options.smoothing}) {
    require(std::isfinite(value) && value > 0.0, "tether guard: found ", value,
            " among its options, expected numbers above zero.");
  }
  for (const Member& m : members_) {
    require(m.from >= 0 && m.from < arms && m.to >= 0 && m.to < arms && m.from != m.to,
            "tether guard: found a member between the arms ", m.from, " and ", m.to,
            ", expected two different ones of ", arms, " from 0.");
  }
}

void TetherGuard::reset() noexcept {
  for (std::size_t k = 0; k < members_.size(); ++k) reset_member(static_cast<int>(k));
  for (Motion& motion : motions_) motion = Motion();
  for (Seen& tip : seen_) tip = Seen();
}

void TetherGuard::reset_member(int member) noexcept {
  const auto k = static_cast<std::size_t>(member);
  lengths_[k] = limits_[k] = kUnknown;
  pushes_[k] = 0;
}

void TetherGuard::detect_compression(int member, double force) noexcept {
  if (force < -options_.least_push) pushes_[member] = 1;
}

void TetherGuard::update_length(int member, double length, double force) noexcept {
  const auto k = static_cast<std::size_t>(member);
  const double stiffness = members_[k].stiffness;
  if (!std::isfinite(length) || !std::isfinite(force)) return;
  detect_compression(member, force);
  if (!(force > 0.0)) {  // slack or compressed: this length is a lower bound of the unloaded one
    lengths_[k] = std::isnan(lengths_[k]) ? length : std::max(lengths_[k], length);
    return;
  }
  const double found = stiffness > 0.0 ? length - force / stiffness : length;
  lengths_[k] =
      std::isnan(lengths_[k]) ? found : lengths_[k] + kLearning * (found - lengths_[k]);
}

void TetherGuard::update_positions(const std::vector<Vector3d>& position) noexcept {
  const double dt = options_.period;
  const double p = std::exp(-2.0 * M_PI * options_.smoothing * dt);
  const double r = 1.0 - p;
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    Seen& tip = seen_[i];
    if (!position[i].allFinite()) continue;
    if (!tip.looked) tip.position = position[i];
    tip.looked = true;
    tip.position += dt * tip.velocity + 0.5 * dt * dt * tip.acceleration;
    tip.velocity += dt * tip.acceleration;
    const Vector3d e = position[i] - tip.position;
    tip.position += (1.0 - p * p * p) * e;
    tip.velocity += 1.5 * r * r * (1.0 + p) / dt * e;
    tip.acceleration += r * r * r / (dt * dt) * e;
  }
}

// Sets L_max. Taut members may carry twice the allowed force, since the other ends already yield at that force,
// and noise must not cause motion. Members that have been slack keep their margin.
void TetherGuard::limit(std::size_t k, double length, double force) noexcept {
  const double stretch = members_[k].stiffness > 0.0 ? 2.0 * force / members_[k].stiffness : 0.0;
  const double taut = lengths_[k] + stretch;
  limits_[k] = std::isnan(limits_[k]) ? taut : std::min(limits_[k], taut);
  if (length < lengths_[k] && pushes_[k] == 0)
    limits_[k] = std::min(limits_[k], std::max(lengths_[k] - options_.margin,
                                               length + options_.margin));
}

void TetherGuard::limit_end_accelerations(std::size_t k, const std::vector<char>& healthy,
                            double force) noexcept {
  const auto from = static_cast<std::size_t>(members_[k].from);
  const auto to = static_cast<std::size_t>(members_[k].to);
  const Vector3d line = seen_[to].position - seen_[from].position;
  const double length = line.norm();
  if (!seen_[from].looked || !seen_[to].looked || std::isnan(lengths_[k]) || !(length > kShortest)) return;
  limit(k, length, force);
  const Vector3d u = line / length;
  const Vector3d relative = seen_[to].velocity - seen_[from].velocity;
  const double rate = u.dot(relative);
  const double turning = (relative - rate * u).squaredNorm() / length;
  const double h = options_.horizon;
  // Each end applies the whole correction, since the other one may have no torque.
  const auto keep = [&](double sign, double bound) {  // sign d2L/dt2 <= most
    const double most = -sign * 2.0 / h * rate - sign * (length - bound) / (h * h);
    const double by_from = sign * (u.dot(seen_[to].acceleration) + turning) - most;
    const double by_to = sign * (turning - u.dot(seen_[from].acceleration)) - most;
    Vector3d& a_from = motions_[from].acceleration;
    Vector3d& a_to = motions_[to].acceleration;
    if (healthy[from] != 0) a_from += std::max(0.0, by_from - sign * a_from.dot(u)) * sign * u;
    if (healthy[to] != 0) a_to -= std::max(0.0, by_to + sign * a_to.dot(u)) * sign * u;
  };
  keep(1.0, limits_[k]);
  const double stiffness = members_[k].stiffness;
  if (pushes_[k] != 0 && stiffness > 0.0) keep(-1.0, lengths_[k] - 2.0 * force / stiffness);
}

void TetherGuard::update(const std::vector<Vector3d>& position, const std::vector<char>& healthy,
                         double force) noexcept {
  update_positions(position);
  for (Motion& motion : motions_) motion.acceleration = -motion.velocity / options_.rest;
  for (std::size_t k = 0; k < members_.size(); ++k)
    limit_end_accelerations(k, healthy, force);
  const double dt = options_.period;
  for (Motion& motion : motions_) {
    const double size = motion.acceleration.norm();
    if (!std::isfinite(size)) {
      motion.acceleration.setZero();
      continue;
    }
    motion.acceleration *= std::min(1.0, options_.acceleration / std::max(size, 1e-12));
    Vector3d next = motion.velocity + dt * motion.acceleration;
    next *= std::min(1.0, options_.speed / std::max(next.norm(), options_.speed));
    motion.acceleration = (next - motion.velocity) / dt;
    motion.position += 0.5 * dt * (motion.velocity + next);
    motion.velocity = next;
  }
}

}  // namespace veridyn
