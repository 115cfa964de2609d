#pragma once

#include <map>
#include <string>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// Reads a URDF file: one frame per link, one coordinate per joint that moves and does not mimic
/// another.
///
/// Revolute, continuous, prismatic, fixed and mimic joints; inertials; limits; damping and friction
/// become viscous_friction and coulomb_friction. Visuals, collisions and transmissions are ignored.
///
/// @throws InvalidInput  no such file, no valid URDF, or a floating or planar joint.
Model read_urdf(const std::string& path);

/// Appearance of the links: their elements `visual` and `collision` as XML, by the name of the
/// link, and robot-wide `material` elements under the empty name.
using UrdfAppearance = std::map<std::string, std::string>;

/// The appearance of a URDF file's links, verbatim; file names of meshes are kept as they are.
/// @throws InvalidInput  no such file, or no XML.
UrdfAppearance urdf_appearance(const std::string& path);

/// Additions to an exported URDF that the model does not hold.
struct UrdfExtras {
  /// Comments on links, by the name of their frame; the comment on the whole robot has the empty
  /// name.
  std::map<std::string, std::string> remarks;
  UrdfAppearance appearance;  ///< appearance of the frames, by name
};

/// A URDF of the same motion and bodies; its root link is `world`.
///
/// A joint variable of one coordinate that is not the coordinate itself becomes a mimic joint; one
/// of several coordinates becomes a chain of them along one line with massless links in between.
/// Whatever URDF cannot express (constants, drive gains, other effects, standard deviations) is
/// omitted, and comments in the file say so.
std::string to_urdf(const Model& arm, const UrdfExtras& extras = {});

}  // namespace veridyn
