#include <memory>

#include "cli/commands.hpp"
#include "veridyn/tool/common_options.hpp"
#include "files/output_file.hpp"
#include "veridyn/report/pages.hpp"

namespace veridyn::cli {
namespace {

struct PageRequest {
  std::string folder, output;
  CommonOptions common;
};

}  // namespace

void add_page_command(CLI::App& tool, Outcome& outcome) {
  const auto request = std::make_shared<PageRequest>();
  CLI::App& command =
      *tool.add_subcommand("page", "One HTML page for a folder of models and results");
  add_value(command, "FOLDER", request->folder,
            "MODEL files, pages, results and recordings of one arm")
      ->required();
  add_value(command, "-o,--output F.html", request->output,
            "Output file (default: FOLDER/index.html)");
  add_common_options(command, request->common);
  command.callback([request, &outcome] {
    if (request->output.empty()) request->output = request->folder + "/index.html";
    require_writable(request->common.json);
    write_file(request->output, project_page(request->folder, request->output, outcome.command_line));
    if (!request->common.json.empty()) write_file(request->common.json, project_json(request->folder, request->output));
  });
}

}  // namespace veridyn::cli
