#pragma once

#include <string>
#include <vector>

#include "veridyn/identification/fleet.hpp"
#include "veridyn/identification/identification.hpp"
#include "veridyn/recordings/recording_quality.hpp"
#include "veridyn/report/robot_info.hpp"

namespace veridyn {

// JSON of `veridyn COMMAND --json`, with the keys of docs/contract.md. Numbers that are not finite
// become null; numbers have all digits, so that reading gives the same double.

/// Result of the command "info".
std::string to_json(const RobotInfo& info);

/// Result of the command "check": every recording with its findings, and all findings again under data_quality.
std::string to_json(const std::vector<RecordingQuality>& recordings);

/// Result of the command "fleet": shared bodies, spread of the individual parameters, members, outliers.
std::string to_json(const Fleet& fleet);

/// Result of the command "identify". condition_number is the one with columns scaled to norm one; `test` is
/// null without test recordings; rank_gap is null where no column depends on others.
std::string to_json(const Identification& id);

}  // namespace veridyn
