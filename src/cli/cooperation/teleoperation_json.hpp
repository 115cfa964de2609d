#pragma once

#include <string>

#include "dvrk/cooperation/board_teleoperation.hpp"

namespace veridyn::cli {

/// JSON of a teleoperation on boards, with the contents of TeleoperationRun::report().
std::string teleoperation_json(const dvrk::TeleoperationRun& run);

}  // namespace veridyn::cli
