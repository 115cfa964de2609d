#pragma once

#include <string>

#include "dvrk/cooperation/board_teleoperation.hpp"

namespace veridyn::cli {

/// A teleoperation on boards for machines, as TeleoperationRun::report() has it for people.
std::string teleoperation_json(const dvrk::TeleoperationRun& run);

}  // namespace veridyn::cli
