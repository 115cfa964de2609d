#include "end_stops.hpp"

#include <algorithm>

namespace veridyn {

void stop_at_ends(World& world, const Model& model, int arm) {
  const std::vector<Coordinate>& joints = model.coordinates();
  const auto beyond = [&](std::size_t i) {
    const double q = world.q(arm)[static_cast<Eigen::Index>(i)];
    return q < joints[i].limits.lower ? -1 : q > joints[i].limits.upper ? 1 : 0;
  };
  bool any = false;
  for (std::size_t i = 0; i < joints.size(); ++i) any = any || beyond(i) != 0;
  if (!any) return;
  VectorXd q = world.q(arm), dq = world.dq(arm);
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const auto j = static_cast<Eigen::Index>(i);
    const int side = beyond(i);
    if (side == 0) continue;
    q[j] = side < 0 ? joints[i].limits.lower : joints[i].limits.upper;
    dq[j] = side < 0 ? std::max(0.0, dq[j]) : std::min(0.0, dq[j]);
  }
  world.hit(arm, q, dq);
}

}  // namespace veridyn
