#pragma once

#include <string>
#include <vector>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// What was found of the error of a channel or of the arm, to stand after "Joint 3 has".
std::string channel_phrase(const Model& arm, const EffectTerm& term,
                           const std::vector<double>& values);

/// True if an effect is asked for whose constant a spectrum proposes. @param wanted  empty: all.
bool asks_for_waves(const std::vector<std::string>& wanted);

}  // namespace veridyn
