#pragma once

#include <string>
#include <vector>

#include "veridyn/excitation/excitation.hpp"

namespace veridyn {

/// The lowest point of a motion: of the shapes of links if these are known, else of the origins of moving
/// frames.
LowestPoint lowest_point(const Model& arm, const std::vector<Capsule>& shapes, const MotionSamples& motion);

/// @throws InvalidInput  the ranges of all revolute joints, two or more, are probably in degrees.
void require_ranges_in_radians(const Model& arm, const std::string& robot);

/// One sentence for each limit that was not checked and each assumption, with the option that checks or sets
/// it.
/// @param powered  the arm whose efforts limit the torques; nullopt without torque limits.
std::vector<std::string> cautions(const Model& arm, const ExcitationOptions& options, const LowestPoint& lowest,
                                  const std::optional<Model>& powered);

}  // namespace veridyn
