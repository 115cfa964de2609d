#pragma once

#include <string>
#include <vector>

#include "veridyn/model/model.hpp"
#include "model/yaml/yaml_node.hpp"

namespace veridyn {

/// `effects:`; a key of an effect that is not among effect_keys() is a parameter.
std::vector<EffectTerm> read_effects(const YamlNode& list,
                                     const std::vector<std::string>& coordinates,
                                     const std::vector<std::string>& frames);

}  // namespace veridyn
