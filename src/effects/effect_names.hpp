#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace veridyn {

// Properties of effects that readers and writers of robot files need.

/// All effects that a robot file or a command may name.
const std::vector<std::string>& effect_names();

/// Keys of an effect in a robot file, except the names of its parameters.
const std::vector<std::string>& effect_keys();

/// True for effects of the whole arm, which need neither `axis` nor `frame`.
bool may_lack_axis(const std::string& effect);

/// True if `offset` is a parameter of the effect itself, so that its axis cannot have one.
bool has_offset_parameter(const std::string& effect);

/// The effect and the parameter that correspond to an attribute of a simulator's joint: "damping",
/// "friction", "armature", "stiffness" or a constant "offset" of its force.
std::optional<std::pair<std::string, std::string>> effect_of_attribute(const std::string& attribute);

}  // namespace veridyn
