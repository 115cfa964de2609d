#include <sys/stat.h>

#include <algorithm>
#include <iostream>
#include <memory>

#include "files/robot_format.hpp"
#include "files/words.hpp"
#include "cli/commands.hpp"
#include "veridyn/tool/common_options.hpp"
#include "files/output_file.hpp"
#include "math/parallel.hpp"
#include "veridyn/tool/messages.hpp"
#include "veridyn/tool/option_checks.hpp"
#include "tool/recording_options.hpp"
#include "veridyn/identification/robot_check.hpp"
#include "veridyn/files/model_file.hpp"
#include "recordings/kept_recordings.hpp"
#include "veridyn/report/json.hpp"
#include "veridyn/report/pages.hpp"

namespace veridyn::cli {
namespace {

struct CheckRequest {
  std::vector<std::string> files;  // a robot may precede the recordings
  PreprocessingOptions reading;
  CommonOptions common;
  bool strict = false;
};

// True for a robot file, or a bare name that is no file.
bool is_robot(const std::string& name) {
  struct stat about {};
  const bool there = ::stat(name.c_str(), &about) == 0;
  const bool file = robot_format(name).has_value() && !ends_with(name, ".json");
  return there ? file && !S_ISDIR(about.st_mode) : file || name.find('.') == std::string::npos;
}

// False for a bare name that is neither a file nor a robot of the installation: it may be a missing recording.
bool is_surely_robot(const std::string& name) {
  struct stat about {};
  if (::stat(name.c_str(), &about) == 0) return is_robot(name);
  const std::vector<std::string> known = robot_names();
  return std::find(known.begin(), known.end(), name) != known.end();
}

void run(CheckRequest& request, Outcome& outcome) {
  require_writable(request.common.json, request.common.report);
  std::vector<std::string> recordings = request.files;
  std::optional<Model> arm;
  if (recordings.size() > 1 && is_robot(recordings.front())) {
    arm = read_robot(recordings.front(), request.common, &request.reading.signals);
    recordings.erase(recordings.begin());
  }
  expect_value(arm || recordings.size() > 1 || !is_surely_robot(recordings.front()), "REC",
               "found the robot '", recordings.front(), "' alone, expected recordings behind it (veridyn info checks a robot)");
  expect_value(arm || request.common.fixed.empty(), "--fix",
               "found no robot, expected one in front of the recordings");
  RecordingOptions reading;
  reading.columns = request.reading.columns;
  reading.rate = request.reading.header_rate;
  reading.signals = request.reading.signals;
  if (arm) reading = recording_options_for(*arm, request.reading);
  reading.first_row = request.reading.first_row;
  reading.row_count = request.reading.row_count;
  std::vector<RecordingQuality> checked(recordings.size());
  std::optional<Busy> busy(std::in_place, request.common, "checking the recordings");
  parallel_for(static_cast<int>(checked.size()), request.common.threads, [&](int k) {
    const auto at = static_cast<std::size_t>(k);
    PreprocessingOptions how = request.reading;
    if (arm && !how.row_count) how.kept = std::make_shared<KeptRecordings>(KeptRecordings::kFewPasses);
    checked[at] = check_rows(recordings[at], open_rows(recordings[at], reading, how.kept.get()));
    if (!arm) return;
    checked[at].findings = merged_findings(check_against(*arm, recordings[at], how), checked[at].findings);
  });
  write_results(request.common, checked, outcome.command_line);
  busy.reset();
  for (const RecordingQuality& quality : checked) {
    std::cout << quality.report();
    if (request.strict && quality.severity() == Severity::kFault) outcome.status = kDataCannotAnswer;
  }
}

}  // namespace

void add_check_command(CLI::App& tool, Outcome& outcome) {
  const auto request = std::make_shared<CheckRequest>();
  CLI::App& command =
      *tool.add_subcommand("check", "Data quality of recordings, and whether they fit a robot");
  add_value(command, "REC [ROBOT] REC...", request->files,
            "Recordings (CSV, bags, MCAP, .npz, .mat, HDF5); a ROBOT may stand in front")
      ->required();
  add_headerless_options(command, request->reading.columns, request->reading.header_rate);
  add_signal_options(command, request->reading.signals);
  add_robot_options(command, request->common);
  add_row_range(command, "--rows", "Samples to check", [request](RowRange rows) {
    request->reading.first_row = rows.first;
    request->reading.row_count = rows.count;
  });
  command.add_flag("--strict", request->strict, "End with status 4 where a fault was found");
  add_common_options(command, request->common);
  add_report_option(command, request->common);
  command.callback([request, &outcome] { run(*request, outcome); });
}

}  // namespace veridyn::cli
