#pragma once

#include <string>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// Reads a URDF file: one frame per link, one coordinate per joint that moves and does not mimic
/// another.
///
/// Revolute, continuous, prismatic, fixed and mimic joints; inertials; limits; damping and friction
/// become viscous_friction and coulomb_friction. Visuals, collisions and transmissions are ignored.
/// @throws InvalidInput  no such file, no valid URDF, a floating or planar joint, or a build
/// without urdfdom.
Model read_urdf(const std::string& path);

/// A URDF of the same motion and bodies; its root link is `world`.
///
/// A joint variable of one coordinate that is not the coordinate itself becomes a mimic joint; one
/// of several coordinates becomes a chain of them along one line with massless links in between.
/// What URDF has no words for (constants, drive gains, other effects, standard deviations) is left
/// out, and comments say so.
std::string to_urdf(const Model& arm);

/// Writes to_urdf() to a file. @throws InvalidInput  the file cannot be written.
void save_urdf(const Model& arm, const std::string& path);

}  // namespace veridyn
