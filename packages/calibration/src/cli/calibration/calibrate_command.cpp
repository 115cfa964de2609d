#include <iostream>

#include "cli/calibration/calibrate_options.hpp"
#include "veridyn/tool/program.hpp"
#include "veridyn/tool/messages.hpp"
#include "veridyn/files/output_file.hpp"

namespace veridyn::cli {

void add_capture_options(CLI::App& command, CaptureOptions& options) {
  add_value(command, "--unit m|cm|mm", options.unit,
            "Unit of positions (default: as the file states, else m)",
            CLI::IsMember({"m", "cm", "mm"}))
      ->group("Recordings");
  add_value(command, "--rate HZ", options.rate, "Sample rate of files without a time column [Hz]",
            CLI::PositiveNumber)
      ->group("Recordings");
}

void add_body_option(CLI::App& command, CaptureOptions& options) {
  add_value(command, "--body NAME", options.body, "Rigid body to use, if a file has several")
      ->group("Recordings");
}

ExitStatus finish_calibration(bool done, const std::string& reason, const std::string& report,
                              const CommonOptions& common, const std::string& json,
                              const std::string& page) {
  if (!done) {
    print_message(reason + ".");
    return kDataCannotAnswer;
  }
  if (!common.json.empty()) write_file(common.json, json);
  if (!common.report.empty()) write_file(common.report, page);
  std::cout << report;
  return kDone;
}

void add_calibrate_command(CLI::App& tool, Outcome& outcome) {
  CLI::App& command = *tool.add_subcommand(
      "calibrate", "Kinematic calibration: axes, remote centre, links, hand-eye");
  command.require_subcommand(1);
  add_calibrate_axis(command, outcome);
  add_calibrate_rcm(command, outcome);
  add_calibrate_links(command, outcome);
  add_calibrate_handeye(command, outcome);
}

}  // namespace veridyn::cli
