#include <iostream>
#include <memory>

#include "cli/commands.hpp"
#include "veridyn/tool/common_options.hpp"
#include "veridyn/tool/messages.hpp"
#include "veridyn/diagnosis/model_comparison.hpp"
#include "files/output_file.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/report/comparison_json.hpp"
#include "veridyn/report/pages.hpp"

namespace veridyn::cli {
namespace {

struct CompareRequest {
  std::string before, after;
  ComparisonOptions options;
  CommonOptions common;
};

void run(const CompareRequest& request, const std::string& command_line) {
  require_writable(request.common.json, request.common.report);
  const Model before = read_model(request.before), after = read_model(request.after);
  const ModelComparison found =
      while_busy(request.common, "comparing", [&] { return compare(before, after, request.options); });
  write_results(request.common, found, command_line);
  std::cout << found.report();
}

}  // namespace

void add_compare_command(CLI::App& tool, Outcome& outcome) {
  const auto request = std::make_shared<CompareRequest>();
  CLI::App& command =
      *tool.add_subcommand("compare", "Significant differences between two models of one arm");
  add_value(command, "BEFORE", request->before, "MODEL that identify or diagnose wrote")
      ->required();
  add_value(command, "AFTER", request->after, "MODEL of the same arm, later or after a repair")
      ->required();
  add_value(command, "--significance P", request->options.significance,
            "Significance level: probability of calling an unchanged arm different (0.05)",
            CLI::Range(1e-12, 0.5));
  add_common_options(command, request->common);
  add_report_option(command, request->common);
  command.callback([request, &outcome] { run(*request, outcome.command_line); });
}

}  // namespace veridyn::cli
