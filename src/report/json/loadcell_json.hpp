#pragma once

#include <string>

#include "veridyn/control/load_cell.hpp"

namespace veridyn {

/// JSON of `loadcell calibrate --json`: offset and scale with their 95 % intervals.
std::string to_json(const LoadCellCalibration& calibration);

}  // namespace veridyn
