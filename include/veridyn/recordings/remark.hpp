#pragma once

#include <string>

#include "veridyn/recordings/recording.hpp"

namespace veridyn {

/// Like write_recording(), with a line "# remark" before the header, which readers skip; empty:
/// none.
void write_recording(const Recording& recording, const std::string& path,
                     const std::string& remark);

}  // namespace veridyn
