#pragma once

#include "veridyn/tool/open_commands.hpp"

namespace veridyn::cli {

/// `excite --for calibration`: poses to calibrate with, written as CSV: t, q.
ExciteExtension excite_poses();

}  // namespace veridyn::cli
