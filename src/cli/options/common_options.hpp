#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "veridyn/recordings/preprocessing.hpp"
#include "veridyn/recordings/recording.hpp"
#include "veridyn/regressor/joint_friction.hpp"

namespace veridyn::cli {

/// Options that every command has.
struct CommonOptions {
  std::string json;    ///< file for the machine-readable result; empty: none
  std::string report;  ///< file for the HTML page; empty: none
  int threads = 0;     ///< 0: one per core
  bool quiet = false;
  std::map<std::string, double> fixed;  ///< coordinates that are not recorded, with their positions
  std::vector<double> drive_gains;  ///< torque per ampere of each joint; empty: those of the file
};

/// A half-open range of rows; without a count: to the end.
struct RowRange {
  long first = 0;
  std::optional<long> count = {};
};

/// Adds --json, --threads, --quiet and --version.
void add_common_options(CLI::App& command, CommonOptions& options);

/// Adds --report, for a command that has a page.
void add_report_option(CLI::App& command, CommonOptions& options);

/// Adds ROBOT, the first argument: a file or a bare name.
void add_robot_argument(CLI::App& command, std::string& robot);

/// Adds an option A:B; A or B may be omitted.
CLI::Option* add_row_range(CLI::App& command, const std::string& option, const std::string& help,
                           std::function<void(RowRange)> take);

/// Adds --columns and --rate, for files without a header.
void add_headerless_options(CLI::App& command, std::vector<std::string>& columns, double& rate,
                            const std::string& rate_option = "--rate");

/// Adds all preprocessing options: filter, velocities, grid, rows, edges.
void add_preprocessing_options(CLI::App& command, PreprocessingOptions& options);

/// Adds --friction.
void add_friction_option(CLI::App& command, JointFriction& friction);

/// Checks before long work that a file can be written. An empty path is no file.
/// @throws InvalidInput  it cannot be written.
void require_writable(const std::string& path);

/// Warns if a recording, or a copy of it, is used for training and for testing.
void warn_of_shared_recordings(const std::vector<std::string>& train,
                               const std::vector<std::string>& test);

/// Warns if a recording, or a copy of it, is used twice for training.
void warn_of_repeated_recordings(const std::vector<std::string>& train);

}  // namespace veridyn::cli
