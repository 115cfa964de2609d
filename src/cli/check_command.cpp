#include <iostream>
#include <memory>

#include "commands.hpp"
#include "common_options.hpp"
#include "math/output_file.hpp"
#include "math/parallel.hpp"
#include "veridyn/report/json.hpp"

namespace veridyn::cli {
namespace {

struct Request {
  std::vector<std::string> recordings;
  RecordingOptions reading;
  CommonOptions common;
};

void run(const Request& request) {
  require_writable(request.common.json);
  std::vector<RecordingQuality> checked(request.recordings.size());
  parallel_for(static_cast<int>(checked.size()), request.common.threads, [&](int k) {
    const auto at = static_cast<std::size_t>(k);
    checked[at] = check_recording(request.recordings[at], request.reading);
  });
  if (!request.common.json.empty()) write_file(request.common.json, to_json(checked));
  for (const RecordingQuality& quality : checked) std::cout << quality.report();
}

}  // namespace

void add_check_command(CLI::App& tool, Outcome&) {
  const auto request = std::make_shared<Request>();
  CLI::App& command = *tool.add_subcommand("check", "Quality of recordings, without a robot");
  command.add_option("REC", request->recordings, "Recordings (CSV)")
      ->required()
      ->option_text("...");
  add_headerless_options(command, request->reading.columns, request->reading.rate);
  add_row_range(command, "--rows", "Rows to look at", [request](RowRange rows) {
    request->reading.first_row = rows.first;
    request->reading.row_count = rows.count;
  });
  add_common_options(command, request->common);
  command.callback([request] { run(*request); });
}

}  // namespace veridyn::cli
