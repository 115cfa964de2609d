#pragma once

namespace veridyn {

/// Whether the data could answer what a calibration was asked.
enum class CalibrationStatus {
  kDone,
  kCannotAnswer,  ///< `reason` says what is missing
};

}  // namespace veridyn
