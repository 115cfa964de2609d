#pragma once

namespace veridyn {

/// Outcome of a calibration.
enum class CalibrationStatus {
  kDone,
  kCannotAnswer,  ///< `reason` states what is missing
};

}  // namespace veridyn
