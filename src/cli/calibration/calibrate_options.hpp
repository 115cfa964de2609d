#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "cli/commands.hpp"
#include "cli/options/common_options.hpp"
#include "veridyn/calibration/capture.hpp"

namespace veridyn::cli {

/// Adds --unit and --rate, which say what a motion-capture file leaves open.
void add_capture_options(CLI::App& command, CaptureOptions& options);

/// Adds --body, where one body of several is wanted.
void add_body_option(CLI::App& command, CaptureOptions& options);

/// Ends a calibration: writes what was asked for, prints the report, or says why there is none.
/// @param json, page  what to write where it could be told.
ExitStatus finish_calibration(bool done, const std::string& reason, const std::string& report,
                              const CommonOptions& common, const std::string& json,
                              const std::string& page);

// The parts of `calibrate`.
void add_calibrate_axis(CLI::App& calibrate, Outcome& outcome);
void add_calibrate_rcm(CLI::App& calibrate, Outcome& outcome);
void add_calibrate_links(CLI::App& calibrate, Outcome& outcome);
void add_calibrate_handeye(CLI::App& calibrate, Outcome& outcome);

}  // namespace veridyn::cli
