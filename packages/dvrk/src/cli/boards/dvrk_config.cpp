#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "veridyn/files/words.hpp"
#include "cli/boards/dvrk_request.hpp"
#include "veridyn/files/output_file.hpp"
#include "veridyn/tool/option_checks.hpp"
#include "veridyn/tool/sound_arguments.hpp"
#include "dvrk/arms/arm_facts.hpp"

namespace veridyn::cli {
namespace {

struct DvrkConfigRequest {
  std::string config;
  std::string arm;
  std::string output;
};

// Prints values in degrees and millimetres, as arms' documents have them; index from 0.
void print_actuator(const dvrk::ActuatorConfig& a, int index) {
  const double factor = a.prismatic ? 1e3 : 180.0 / M_PI;
  const char* unit = a.prismatic ? "mm" : "deg";
  fmt::print("  {:>2}  board {:>2} axis {}  ", index, a.board, a.axis);
  if (a.max_current > 0.0) {
    fmt::print("{:+.6g} {unit}/count  {:.4g} .. {:.4g} {unit}  {:.4g} A, {:.4g} {}  zero {}\n",
               factor * a.bits_to_position, factor * a.lower, factor * a.upper, a.max_current,
               a.max_current / a.effort_to_amps, a.prismatic ? "N" : "N m",
               std::lround(a.amps_to_bits.offset), fmt::arg("unit", unit));
  } else {
    fmt::print("inputs only\n");
  }
}

void print_config(const dvrk::IoConfig& config) {
  for (const dvrk::RobotConfig& robot : config.robots) {
    fmt::print("{} on {}{}{}\n", robot.name, robot.hardware,
               robot.serial.empty() ? "" : ", serial number " + robot.serial,
               robot.io_only ? ", inputs and outputs only" : "");
    for (const dvrk::BoardSerial& own : robot.board_serials)
      fmt::print("  board {:>2} has the serial number {}\n", own.board, own.serial);
    for (int k = 0; k < robot.size(); ++k)
      print_actuator(robot.actuators[k], k);
  }
  fmt::print("{} digital inputs, {} digital outputs, {} instrument chips\n",
             config.digital_inputs.size(), config.digital_outputs.size(),
             config.dallas_chips.size());
  for (const std::string& remark : config.remarks) fmt::print("note: {}\n", remark);
}

void run(const DvrkConfigRequest& request) {
  if (request.config.empty() == request.arm.empty())
    throw CLI::ValidationError("dvrk config", "expected one of --config and --arm");
  const bool json = ends_with(request.output, ".json");
  if (!request.output.empty() && !json && !ends_with(request.output, ".xml"))
    throw CLI::ValidationError(
        "--output", "found '" + request.output + "', expected a file that ends in .xml or .json");
  require_writable(request.output);
  dvrk::IoConfig config;
  if (request.config.empty()) {
    expect_one_of("--arm", request.arm, dvrk::arm_names());
    const dvrk::ArmFacts arm = dvrk::read_arm(request.arm);
    config = dvrk::nominal_config(arm);
    for (const std::string& line : arm.unsure)
      config.remarks.push_back("nobody has checked: " + line);
  } else {
    config = dvrk::read_io_config(request.config);
  }
  if (!request.output.empty())
    write_file(request.output, json ? dvrk::to_io_json(config) : dvrk::to_io_xml(config));
  print_config(config);
}

}  // namespace

void add_dvrk_config(CLI::App& dvrk) {
  const auto request = std::make_shared<DvrkConfigRequest>();
  CLI::App& command =
      *dvrk.add_subcommand("config", "Check a configuration, convert it between XML and JSON");
  add_value(command, "--config FILE", request->config,
            "sawRobotIO1394 file, XML (version 5) or JSON");
  add_value(command, "--arm NAME", request->arm,
            "Nominal configuration of a known arm, instead of --config");
  add_output_option(command, "-o,--output", request->output,
                    "Write the configuration; the ending of the file name decides the format")
      ->option_text("FILE.xml|FILE.json");
  command.set_version_flag("--version", "veridyn " VERIDYN_VERSION);
  command.callback([request] { run(*request); });
}

}  // namespace veridyn::cli
