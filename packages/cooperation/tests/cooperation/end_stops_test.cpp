#include "cooperation/end_stops.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "simulation/plant_support.hpp"
#include "support/near.hpp"
#include "veridyn/simulation/world.hpp"

namespace veridyn {
namespace {

// Two joints: one at an end, the other free. Outward motion stops there, inward motion continues.
TEST(EndStops, AJointStopsAtItsEndStop) {
  ModelDescription description = robot("planar-2r").description();
  description.coordinates[0].limits.lower = -1.0;
  description.coordinates[0].limits.upper = 2.0;
  const Model arm(description);
  std::vector<WorldArm> arms;
  arms.push_back({arm, std::make_unique<Plant>(arm)});
  World world(std::move(arms), {});
  const struct {
    double q, dq, q_after, dq_after;
  } cases[] = {{2.5, 3.0, 2.0, 0.0}, {2.5, -3.0, 2.0, -3.0}, {-1.5, -3.0, -1.0, 0.0},
               {-1.5, 3.0, -1.0, 3.0}, {2.0, 3.0, 2.0, 3.0}, {-1.0, -3.0, -1.0, -3.0}, {0.5, 3.0, 0.5, 3.0}};
  for (const auto& c : cases) {
    world.set_state(0, Eigen::Vector2d(c.q, 0.3), Eigen::Vector2d(c.dq, -0.7));
    stop_at_ends(world, arm, 0);
    EXPECT_TRUE(near(world.q(0), Eigen::Vector2d(c.q_after, 0.3), 0.0)) << c.q << " " << c.dq;
    EXPECT_TRUE(near(world.dq(0), Eigen::Vector2d(c.dq_after, -0.7), 0.0)) << c.q << " " << c.dq;
  }
}

}  // namespace
}  // namespace veridyn
