#pragma once

#include <string>

#include "veridyn/calibration/axes.hpp"
#include "veridyn/calibration/hand_eye.hpp"
#include "veridyn/calibration/links.hpp"
#include "veridyn/calibration/remote_center.hpp"

namespace veridyn {

// Pages of `calibrate --report`: one HTML file that needs neither a network nor other files, with
// the numbers of to_json(), axes and frames in space, and histograms of the residuals.

/// @param command  the command line of the run, shown verbatim; empty: none.
std::string to_page(const AxesCalibration& axes, const std::string& command = "");
std::string to_page(const RemoteCenter& centre, const std::string& command = "");
std::string to_page(const LinksCalibration& links, const std::string& command = "",
                    const std::string& comparison = "");
std::string to_page(const HandEye& pose, const std::string& command = "");

}  // namespace veridyn
