#pragma once

#include "veridyn/dynamics/torque_regressor.hpp"

namespace veridyn {

/// An older name, until every file that includes this one says TorqueRegressor.
using RegressorBatch = TorqueRegressor;

}  // namespace veridyn
