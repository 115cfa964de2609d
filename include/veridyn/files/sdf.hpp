#pragma once

#include <string>

#include "veridyn/files/urdf.hpp"

namespace veridyn {

/// SDFormat of an arm with values, fixed to the world: one link per frame, joints with limits, damping and
/// friction, inertials about the centre of mass. Gravity is a comment, because SDF keeps it in the world.
///
/// A joint variable of one coordinate that is not the coordinate itself becomes a `mimic` of
/// version 1.11; one of several coordinates a chain of mimics along one line, with massless links
/// in between. A link with the name of a joint gets the suffix "_link". Whatever SDF cannot represent is
/// omitted, and comments say so.
/// @throws InvalidInput  a body has no values.
std::string to_sdf(const Model& arm, const UrdfExtras& extras = {});

}  // namespace veridyn
