#pragma once

#include <string>
#include <vector>

#include "recordings/signals/raw_recording.hpp"

namespace veridyn::recordings {

/// What the name of a column says: a signal of a joint, as in `elbow/position`, `actual_q_0`,
/// `qpos3`, `tau_elbow`, `elbow.vel [deg/s]`. Desired and commanded values, and those of a tool, are
/// none.
/// @returns the field with joint and signal, or without them where the name says no such thing.
RawField field_of(const std::string& path);

/// The unit in brackets behind a name, as "deg" of `q1 [deg]`; empty: none.
std::string unit_in(const std::string& name);

/// Words of a name, in lower case: cut at signs other than letters and digits, before a number, and
/// before a capital behind a small letter.
std::vector<std::string> words_of(const std::string& name);

}  // namespace veridyn::recordings
