#pragma once

#include <string>
#include <vector>

namespace veridyn {

/// Every effect that a robot file may name, in the order of CONTRACT.md. `none`, which stands there
/// too, is the verdict that there is no effect.
const std::vector<std::string>& effect_names();

/// Keys of an effect in a robot file that are not the names of its parameters.
const std::vector<std::string>& effect_keys();

/// True for effects of the whole arm, which need neither `axis` nor `frame`.
bool may_lack_axis(const std::string& effect);

/// True where `offset` is the effect's parameter and not that of its axis, which could not be told
/// from it.
bool has_offset_parameter(const std::string& effect);

}  // namespace veridyn
