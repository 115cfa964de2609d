#pragma once

#include <string>

#include "veridyn/calibration/axes.hpp"
#include "veridyn/calibration/hand_eye.hpp"
#include "veridyn/calibration/links.hpp"
#include "veridyn/calibration/pose_design.hpp"
#include "veridyn/calibration/remote_center.hpp"

namespace veridyn {

// JSON of `veridyn calibrate PART --json`, with the keys of docs/contract.md. `interval` has the
// two ends of a 95 % interval; `interval_m` and `interval_deg` are radii that contain the point,
// line or pose in 95 of 100 cases.

/// `calibrate axis`: axes, links, bodies, cannot_tell.
std::string to_json(const AxesCalibration& axes);

/// `calibrate rcm`: rcm, tip, rms, interval.
std::string to_json(const RemoteCenter& centre);

/// `calibrate links`: constants, named, held_out_rms; `comparison` is a sentence on another result.
std::string to_json(const LinksCalibration& links, const std::string& model_file = "",
                    const std::string& comparison = "");

/// `calibrate handeye`: transform, form, residuals.
std::string to_json(const HandEye& pose);

/// `excite --for calibration`: poses, predictions, gain.
std::string to_json(const PoseDesign& design);

}  // namespace veridyn
