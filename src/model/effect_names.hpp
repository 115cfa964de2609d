#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace veridyn {

// What the reader and writer of robot files must know of effects. Declared here, where it is
// needed; answered by src/effects/registry.cpp, from what every effect says of itself.

/// Every effect that a robot file or a command may name. `none`, the verdict that there is no
/// effect, is not among them.
const std::vector<std::string>& effect_names();

/// Keys of an effect in a robot file that are not the names of its parameters.
const std::vector<std::string>& effect_keys();

/// True for effects of the whole arm, which need neither `axis` nor `frame`.
bool may_lack_axis(const std::string& effect);

/// True where `offset` is the effect's parameter and not that of its axis, which could not be told
/// from it.
bool has_offset_parameter(const std::string& effect);

/// The effect and its parameter that say the same as an attribute of URDF's <dynamics>.
std::optional<std::pair<std::string, std::string>> effect_of_urdf(const std::string& attribute);

}  // namespace veridyn
