#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "cli/commands.hpp"
#include "veridyn/tool/common_options.hpp"

namespace veridyn::cli {

/// Options of `excite --for calibration`.
struct PosesRequest {
  std::string purpose = "identification";
  std::string frame;
  int poses = 30;
};

/// Adds --for, --frame and --poses.
void add_poses_options(CLI::App& command, PosesRequest& request);

/// @throws CLI::ValidationError  an option was given that applies to motions only.
void expect_no_motion_options(const CLI::App& command);

/// Designs poses to calibrate with and writes them as CSV: t, q.
ExitStatus excite_poses(const std::string& robot, const std::string& output,
                        const PosesRequest& request, unsigned seed, double limit_share,
                        const CommonOptions& common);

}  // namespace veridyn::cli
