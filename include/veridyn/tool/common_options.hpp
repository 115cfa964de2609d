#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "veridyn/files/output_file.hpp"
#include "veridyn/recordings/preprocessing.hpp"
#include "veridyn/recordings/recording.hpp"
#include "veridyn/identification/joint_friction.hpp"

namespace veridyn::cli {

/// Options that every command has.
struct CommonOptions {
  std::string json;    ///< file for the machine-readable result; empty: none
  std::string report;  ///< file for the HTML page; empty: none
  int threads = 0;     ///< 0: one per core
  bool quiet = false;
  std::map<std::string, double> fixed;  ///< coordinates that are not recorded, with their positions
  std::vector<double> gravity;  ///< gravity in the robot file's base [m/s^2]; empty: that of the file
  std::vector<double> drive_gains;  ///< torque per ampere of each joint; empty: those of the file
};

/// A half-open range of rows; without a count it extends to the end.
struct RowRange {
  long first = 0;
  std::optional<long> count = {};
};

/// Adds an option with a value. @param name  the option and the word that the help shows for its value, "--rate HZ";
/// a positional argument is its own word, "ROBOT".
template <typename T, typename... Checks>
CLI::Option* add_value(CLI::App& command, const std::string& name, T& target,
                       const std::string& help, const Checks&... checks) {
  const std::size_t blank = name.find(' ');
  CLI::Option* const option = command.add_option(name.substr(0, blank), target, help);
  (option->check(checks), ...);
  return option->option_text(blank == std::string::npos ? " " : name.substr(blank + 1));
}

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

/// Checks several files.
template <typename... More>
void require_writable(const std::string& path, const std::string& next, const More&... more) {
  require_writable(path);
  require_writable(next, more...);
}

/// Writes --json and --report where they were given. @param page  arguments of to_page() after the result.
template <typename Result, typename... Page>
void write_results(const CommonOptions& common, const Result& result, const Page&... page) {
  if (!common.json.empty()) write_file(common.json, to_json(result));
  if (!common.report.empty()) write_file(common.report, to_page(result, page...));
}

/// Warns if a recording, or a copy of it, is used for training and for testing.
void warn_of_shared_recordings(const std::vector<std::string>& train,
                               const std::vector<std::string>& test);

/// Warns if a recording, or a copy of it, is used twice for training.
void warn_of_repeated_recordings(const std::vector<std::string>& train);

}  // namespace veridyn::cli
