#include "veridyn/simulation/object.hpp"

#include <algorithm>

namespace veridyn {

double tension(const Member& member, double length, double rate) noexcept {
  if (!member.attached) return 0.0;
  const double stretch = length - member.rest_length;
  if (member.pulls_only && stretch <= 0.0) return 0.0;
  const double pull = member.stiffness * stretch + member.damping * rate;
  return member.pulls_only ? std::max(0.0, pull) : pull;
}

double elastic_energy(const Member& member, double length) noexcept {
  if (!member.attached) return 0.0;
  const double stretch = length - member.rest_length;
  if (member.pulls_only && stretch <= 0.0) return 0.0;
  return 0.5 * member.stiffness * stretch * stretch;
}

double contact_force(const Wall& wall, double depth, double rate) noexcept {
  if (depth <= 0.0) return 0.0;
  return std::max(0.0, (wall.stiffness + wall.stiffening * depth) * depth + wall.damping * rate);
}

Eigen::Vector3d contact_force(const Wall& wall, const Eigen::Vector3d& position,
                              const Eigen::Vector3d& velocity) noexcept {
  const double depth = -wall.normal.dot(position - wall.point);
  const double rate = -wall.normal.dot(velocity);
  Eigen::Vector3d force = contact_force(wall, depth, rate) * wall.normal;
  if (depth > 0.0) force -= wall.drag * (velocity + rate * wall.normal);
  return force;
}

}  // namespace veridyn
