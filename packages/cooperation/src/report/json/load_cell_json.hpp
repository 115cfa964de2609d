#pragma once

#include <string>

#include "veridyn/control/load_cell.hpp"

namespace veridyn {

/// `loadcell calibrate`: offset and scale.
std::string to_json(const LoadCellCalibration& calibration);

}  // namespace veridyn
