#pragma once

#include <optional>
#include <string>

#include "veridyn/recordings/signal_choice.hpp"

namespace veridyn::recordings {

/// Factor from a unit of a signal ("q", "dq", "ddq", "tau", "i", "t") to SI, or nullopt for an
/// unknown unit; a leading - reverses the sign. `tau` in A has the factor of a current.
std::optional<double> unit_factor(const std::string& signal, const std::string& unit);

/// True for a unit of current.
bool is_current_unit(const std::string& unit);

/// The chosen unit of a signal of joint number `joint` (from 1), or "".
std::string unit_of(const SignalChoice& choice, const std::string& signal, int joint);

/// The factor for one column: degrees apply to revolute joints, millimetres to prismatic ones.
double factor_for(const SignalChoice& choice, const std::string& signal, int joint);

/// @throws InvalidInput  a signal or unit that is not known.
void require_known_units(const SignalChoice& choice);

/// @throws InvalidInput  a unit is given for a joint beyond those of the recording.
void require_joints_of(const SignalChoice& choice, int joints, const std::string& path);

}  // namespace veridyn::recordings
