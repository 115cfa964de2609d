#pragma once

#include <string_view>

namespace veridyn {

/// What pages of this package add to the scripts of a page: "script.js".
std::string_view calibration_file(std::string_view name);

}  // namespace veridyn
