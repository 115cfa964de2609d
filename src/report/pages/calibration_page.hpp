#pragma once

#include <string>

#include "veridyn/calibration/axes.hpp"
#include "veridyn/calibration/hand_eye.hpp"
#include "veridyn/calibration/links.hpp"
#include "veridyn/calibration/remote_center.hpp"

namespace veridyn {

// What `calibrate --report` writes: one HTML file that needs neither a network nor other files, with
// the numbers of to_json(), axes and frames in space, and histograms of what is left over.

/// @param command  the command line of the run, shown as it is; empty: none.
std::string to_page(const AxesCalibration& axes, const std::string& command = "");
std::string to_page(const RemoteCenter& centre, const std::string& command = "");
std::string to_page(const LinksCalibration& links, const std::string& command = "",
                    const std::string& comparison = "");
std::string to_page(const HandEye& pose, const std::string& command = "");

}  // namespace veridyn
