#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "veridyn/tool/program.hpp"
#include "veridyn/tool/common_options.hpp"
#include "veridyn/calibration/capture.hpp"

namespace veridyn::cli {

/// Adds --unit and --rate, for what a motion-capture file does not state.
void add_capture_options(CLI::App& command, CaptureOptions& options);

/// Adds --body, to select one body of several.
void add_body_option(CLI::App& command, CaptureOptions& options);

/// Ends a calibration: writes the files and prints the report, or the reason for a failure.
/// @param json, page  contents of the files for a successful calibration.
ExitStatus finish_calibration(bool done, const std::string& reason, const std::string& report,
                              const CommonOptions& common, const std::string& json,
                              const std::string& page);

void add_calibrate_command(CLI::App& tool, Outcome& outcome);

void add_calibrate_links(CLI::App& calibrate, Outcome& outcome);

}  // namespace veridyn::cli
