#pragma once

#include <string>
#include <vector>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// Description of an error of a channel or of the arm, to follow "Joint 3 has".
std::string channel_phrase(const Model& arm, const EffectTerm& term,
                           const std::vector<double>& values);

}  // namespace veridyn
