#pragma once

#include <string>
#include <vector>

#include "diagnosis/causes/hypotheses.hpp"

namespace veridyn {

/// What stages of a diagnosis must know about effects; the effects themselves say it.

/// Friction along an axis.
bool is_friction(const std::string& effect);

/// The hypothesis is the error of a channel or a tilt of the base.
bool is_channel(const Hypothesis& h);

/// What was found of such an error, to stand after "Joint 3 has".
std::string channel_phrase(const Model& arm, const EffectTerm& term,
                           const std::vector<double>& values);

/// True if an effect is asked for whose constant a spectrum proposes. @param wanted  empty: all.
bool asks_for_waves(const std::vector<std::string>& wanted);

}  // namespace veridyn
