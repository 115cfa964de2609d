#pragma once

#include <string>
#include <vector>

#include "veridyn/excitation/excitation.hpp"

namespace veridyn {

/// The lowest point of a motion: of the shapes of links where they are known, else of the origins of
/// frames that move.
LowestPoint lowest_point(const Model& arm, const std::vector<Capsule>& shapes, const MotionSamples& motion);

/// @throws InvalidInput  the ranges of all turning joints, two or more, look like degrees.
void require_ranges_in_radians(const Model& arm, const std::string& robot);

/// Unchecked limits and assumptions, one sentence each, with the option that checks or sets it.
/// @param powered  the arm whose efforts limit the torques, where there is one.
std::vector<std::string> cautions(const Model& arm, const ExcitationOptions& options, const LowestPoint& lowest,
                                  const std::optional<Model>& powered);

}  // namespace veridyn
