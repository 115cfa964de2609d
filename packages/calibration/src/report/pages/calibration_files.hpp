#pragma once

#include <string_view>

namespace veridyn {

/// Scripts that this package adds to a page: "script.js".
std::string_view calibration_file(std::string_view name);

}  // namespace veridyn
