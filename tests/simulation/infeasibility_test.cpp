#include <gtest/gtest.h>

#include <cmath>

#include "simulation/plant_support.hpp"

namespace veridyn {
namespace {

// A massless link of length l and a second one with m = 1 kg, h_x = 1 kg m and the inertia I about its joint:
//
//   det M = l^2 (I - cos(q2)^2)
//
// For I below one it is negative where |cos q2| is nearly one. Neither the corners nor the middle of the range come near
// such a pose, and the steps of a search from there are multiples of pi.
Model light_arm(double I) {
  ModelDescription d = planar_2r().description();
  InertialParameters second = InertialParameters::Zero();
  second[0] = second[1] = 1.0;
  second[9] = I;
  int body = 0;
  for (Frame& frame : d.frames) {
    if (frame.body) frame.body->phi = body++ == 0 ? InertialParameters(InertialParameters::Zero()) : second;
  }
  d.coordinates[1].limits.lower = M_PI / 2;
  d.coordinates[1].limits.upper = M_PI / 2 + 640.0 * M_PI;
  return Model(std::move(d));
}

TEST(Infeasibility, AnIndefiniteMassMatrixAnywhereInTheRangeIsFound) {
  EXPECT_EQ(infeasibility(light_arm(1.001)), "");
  const std::string trouble = infeasibility(light_arm(0.999));
  EXPECT_NE(trouble.find("is not positive definite"), std::string::npos) << trouble;
}

}  // namespace
}  // namespace veridyn
