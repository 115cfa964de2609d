#pragma once

#include <string>
#include <vector>

#include "closed_loop.hpp"

namespace veridyn {

/// One equilibrium along a scenario's motion.
struct RestPoint {
  std::string phase;
  double time = 0.0;  ///< [s] since the start
  LinearPoint loop;
};

/// The middle and the end of every phase: positions of arms that follow exactly,
/// with the wanted forces. Released members are not attached.
/// @throws InvalidInput  as scenario_models().
std::vector<RestPoint> rest_points(const Scenario& scenario);

}  // namespace veridyn
