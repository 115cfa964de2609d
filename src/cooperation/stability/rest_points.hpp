#pragma once

#include <string>
#include <vector>

#include "closed_loop.hpp"

namespace veridyn {

/// One point of rest along a scenario's motion.
struct RestPoint {
  std::string phase;
  double time = 0.0;  ///< [s] since the start
  LinearPoint loop;
};

/// The start and the middle and the end of every phase: where arms would stand if they followed
/// exactly, with the forces that are wanted there. Members that are let go are left out.
///
/// @throws InvalidInput  as scenario_models().
std::vector<RestPoint> rest_points(const Scenario& scenario);

}  // namespace veridyn
