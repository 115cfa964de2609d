#pragma once

#include <string>
#include <vector>

#include "recordings/signals/raw_recording.hpp"

namespace veridyn::recordings {

/// Parses the name of a column: a signal of a joint, as in `elbow/position`, `actual_q_0`, `qpos3`,
/// `tau_elbow`, `elbow.vel [deg/s]`. Desired and commanded values, and those of a tool, are not recognised.
/// @returns the field with joint and signal, or without them if the name contains none.
RawField field_of(const std::string& path);

/// The unit in brackets behind a name, as "deg" of `q1 [deg]`; empty: none.
std::string unit_in(const std::string& name);

/// Words of a name, in lower case: separated by any other character than letters and digits, before a number,
/// and before a capital after a small letter.
std::vector<std::string> words_of(const std::string& name);

}  // namespace veridyn::recordings
