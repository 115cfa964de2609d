#include <algorithm>
#include <memory>
#include <sstream>

#include "emulator/board_events.hpp"
#include "cli/boards/dvrk_request.hpp"
#include "veridyn/tool/messages.hpp"
#include "veridyn/tool/option_checks.hpp"
#include "veridyn/tool/sound_arguments.hpp"
#include "dvrk/arms/arm_facts.hpp"

namespace veridyn::cli {
namespace {

void add_config_options(CLI::App& command, DvrkRequest& request) {
  add_value(command, "--config FILE", request.config,
            "sawRobotIO1394 file of the arm, XML or JSON");
  add_value(command, "--robot NAME", request.robot,
            "Robot in the configuration, if there are several");
  add_value(command, "--instrument NAME", request.instrument,
            "Instrument, which sets the coupling of the last joints");
}

void add_arm_options(CLI::App& command, DvrkRequest& request) {
  add_config_options(command, request);
  add_value(command, "--arm NAME", request.arm,
            "Nominal configuration of a known arm (PSM1 to PSM3, MTML, MTMR, ECM); with --config: "
            "the known arm whose coupling and gains apply");
}

void add_client_options(CLI::App& command, DvrkRequest& request) {
  add_arm_options(command, request);
  add_value(command, "--host HOST", request.host, "Address of the boards (127.0.0.1)");
  add_value(command, "--port PORT", request.port, "UDP port of the boards (1394)");
  add_value(command, "--rate HZ", request.rate, "Cycle rate [Hz] (default: monitor 25, else 1500)",
            CLI::Range(1.0, 10000.0));
  add_value(command, "--watchdog S", request.watchdog,
            "Watchdog period, after which boards without a packet switch their amplifiers off [s]; "
            "read and monitor set it only with --home (0.03)",
            CLI::Range(0.001, 0.34));
  add_value(command, "--mtu BYTES", request.mtu,
            "Largest packet of the network to the boards [byte] (1500)", CLI::Range(576, 65535));
  command.add_flag("--firewire", request.firewire,
                   "FireWire joins the boards, though they are FPGA V3 with firmware 9, which are "
                   "otherwise taken for boards that Ethernet alone joins");
  add_value(command, "--protocol automatic|sequential|broadcast-write|broadcast", request.protocol,
            "sequential: one board after the other; broadcast-write: one write for all; broadcast: "
            "one read and one write for all; to a reading command its query is a write, too, that "
            "only keeps watchdogs quiet (what the firmware allows)",
            CLI::IsMember({"automatic", "sequential", "broadcast-write", "broadcast"}));
}

void add_reading_options(CLI::App& command, DvrkRequest& request) {
  command.add_flag("--home", request.home,
                   "First load encoders that were not loaded since power-up from the "
                   "potentiometers, and set watchdogs; refused while any motor has power");
  command.add_flag("--announce", request.announce,
                   "Send the first two packets of a session (IP address, PHY request), which "
                   "boards need once after they were switched on");
}

void add_seconds(CLI::App& command, DvrkRequest& request, const char* help) {
  add_value(command, "--seconds S", request.seconds, help, CLI::PositiveNumber);
}

using Action = ExitStatus (*)(const DvrkRequest&);

CLI::App& add(CLI::App& dvrk, const char* name, const char* help, Action action, Outcome& outcome,
              const std::shared_ptr<DvrkRequest>& request) {
  CLI::App& command = *dvrk.add_subcommand(name, help);
  add_common_options(command, request->common);
  request->command = &command;
  command.callback([=, &outcome] { outcome.status = action(*request); });
  return command;
}

void add_emulate(CLI::App& dvrk, Outcome& outcome) {
  const auto request = std::make_shared<DvrkRequest>();
  CLI::App& command = add(dvrk, "emulate", "Emulate boards with a simulated arm, in real time",
                          run_dvrk_emulate, outcome, request);
  add_config_options(command, *request);
  add_value(command, "--arm NAME...", request->arms,
            "Nominal configuration of known arms (PSM1 to PSM3, MTML, MTMR, ECM) on one bus; with "
            "--config: the known arm whose coupling applies");
  add_value(command, "--model MODEL...", request->models,
            "Model of the simulated arm, one for all arms or one for each (default: the joints do "
            "not move)");
  add_value(command, "--port PORT", request->port, "UDP port to listen on; 0: any (1394)");
  command.add_flag("--all-addresses", request->everywhere,
                   "Also accept packets from other machines: any of them can then drive the arm "
                   "(default: this machine only)");
  add_value(command, "--firmware 7|8|9", request->firmware, "Firmware version of the boards (8)",
            CLI::Range(7, 9));
  command.add_flag("--ethernet-only", request->ethernet_only,
                   "Emulate FPGA V3 boards (firmware 9) that are connected by Ethernet only");
  command.add_flag(
      "--io-expander", request->io_expander,
      "Emulate QLA 1.5 boards: I/O expander, voltage mode, comparator of the motor supply");
  add_value(
      command, "--start Q,Q,...", request->start,
      "Initial joint positions (default: 0 where that is well inside the limits, else the middle)")
      ->delimiter(',');
  add_value(command, "--event EVENT@S", request->events,
            "Fault or event at a time, from the list below; can be repeated");
  command.footer(dvrk::board_event_help());
  add_value(command, "--pot-noise BITS", request->pot_noise,
            "Standard deviation of the potentiometers [bit] (3)", CLI::NonNegativeNumber);
  add_value(command, "--current-noise BITS", request->current_noise,
            "Standard deviation of measured currents [bit] (4)", CLI::NonNegativeNumber);
  add_value(command, "--instrument-chip BOARD=FILE", request->chips,
            "Memory of the Dallas chip on a board, up to 2048 bytes (no chip)");
  add_output_option(command, "--config-out", request->config_out,
                    "Write the configuration in use (XML)");
  add_seconds(command, *request, "Duration [s] (default: until Ctrl-C)");
}

void add_monitor_and_read(CLI::App& dvrk, Outcome& outcome) {
  const auto monitor = std::make_shared<DvrkRequest>();
  monitor->rate = 25.0;
  CLI::App& live = add(dvrk, "monitor",
                       "Show joints, currents, temperatures and faults; sends no write packet, so "
                       "it can run beside the program that drives the arm",
                       run_dvrk_monitor, outcome, monitor);
  add_client_options(live, *monitor);
  add_reading_options(live, *monitor);
  add_seconds(live, *monitor, "Duration [s] (default: until Ctrl-C)");

  const auto read = std::make_shared<DvrkRequest>();
  read->seconds = 30.0;
  CLI::App& recording =
      add(dvrk, "read",
          "Record positions, velocities and efforts; sends no write packet, power stays as it is",
          run_dvrk_read, outcome, read);
  add_client_options(recording, *read);
  add_reading_options(recording, *read);
  add_seconds(recording, *read, "Duration [s] (30)");
  add_output_option(recording, "-o,--output", read->output, "Output file of the recording")
      ->option_text("REC.csv")
      ->required();
}

void add_run(CLI::App& dvrk, Outcome& outcome) {
  const auto run = std::make_shared<DvrkRequest>();
  run->seconds = 30.0;
  CLI::App& motion = add(dvrk, "run", "Follow a trajectory with a controller and record it",
                         run_dvrk_run, outcome, run);
  add_client_options(motion, *run);
  motion.add_flag(
      "--emulate", run->emulate,
      "Run on emulated boards within this program, with the arm of --model and simulated time");
  add_value(motion, "--event EVENT@S", run->events,
            "With --emulate: fault or event at a time, from the list of `dvrk emulate --help`");
  add_value(motion, "--controller pid|computed-torque|impedance|gravity", run->controller,
            "pid: one per joint; computed-torque: the joints follow, with the model as "
            "feed-forward; impedance: the tip follows like a spring; gravity: the arm is "
            "weightless, without a trajectory. All but pid need --model (pid)",
            CLI::IsMember({"pid", "computed-torque", "impedance", "gravity"}));
  add_value(motion, "--trajectory TRAJ.csv", run->trajectory,
            "CSV file with t and q, optionally dq");
  add_output_option(motion, "-o,--output", run->output, "Output file of the recording")
      ->option_text("REC.csv")
      ->required();
  add_value(motion, "--model MODEL", run->model,
            "A robot with values: the controller's, or the one whose inertia the PID's gains shall "
            "fit (those of the laboratory for a known arm)");
  add_value(motion, "--gains FILE", run->gains,
            "YAML file, with --model: lists p, i and d of a PID, p [1/s^2] and d [1/s] of computed "
            "torque, or mass, damping and stiffness (3 each) of an impedance");
  add_value(motion, "--tip FRAME", run->tip,
            "Frame of the impedance (default: the one with most joints)");
  add_value(motion, "--stiffness K", run->stiffness, "Stiffness of the impedance (800 N/m)",
            CLI::PositiveNumber);
  add_seconds(motion, *run, "Duration of gravity compensation [s] (30)");
  add_value(motion, "--approach-speed V", run->approach_speed,
            "Speed of the approach to the first set point (0.25 rad/s)", CLI::PositiveNumber);
  add_value(motion, "--largest-error Q[,Q...]", run->largest_error,
            "Largest tracking error, beyond which power goes off: one number per joint in its own "
            "unit, or one in rad for the revolute joints (0.35 rad, 0.02 m for prismatic ones); "
            "not for gravity")
      ->delimiter(',')
      ->check(CLI::PositiveNumber);
}

}  // namespace

DvrkArm read_dvrk_arm(const DvrkRequest& request) {
  if (request.config.empty() && request.arm.empty())
    throw CLI::ValidationError("dvrk", "expected --config or --arm");
  expect_prerequisites(*request.command, {{"--robot", !request.config.empty(), "--config"}});
  const std::vector<std::string> known = dvrk::arm_names();
  if (!request.arm.empty()) expect_one_of("--arm", request.arm, known);
  DvrkArm arm;
  arm.config = request.config.empty() ? dvrk::nominal_config(dvrk::read_arm(request.arm))
                                      : dvrk::read_io_config(request.config);
  if (!request.robot.empty()) {
    std::vector<std::string> robots;
    for (const dvrk::RobotConfig& robot : arm.config.robots) robots.push_back(robot.name);
    expect_one_of("--robot", request.robot, robots);
  }
  arm.robot = arm.config.robot(request.robot);
  const auto is_known = [&](const std::string& name) {
    return std::find(known.begin(), known.end(), name) != known.end();
  };
  expect_value(request.arm.empty() || request.arm == arm.robot.name || !is_known(arm.robot.name),
               "--arm", "found ", request.arm, ", but the robot of ", request.config, " is ",
               arm.robot.name);
  const std::string name = request.arm.empty() ? arm.robot.name : request.arm;
  expect_prerequisites(*request.command, {{"--instrument", is_known(name), "--arm with a known arm"}});
  if (is_known(name)) {
    const dvrk::ArmFacts facts = dvrk::read_arm(name);
    arm.coupling = value_of("--instrument", [&] { return facts.coupling(request.instrument); });
    expect_value(arm.coupling.rows() == arm.robot.size(), "--arm", name, " has ",
                 arm.coupling.rows(), " actuators, but ", arm.robot.name, " has ",
                 arm.robot.size());
  }
  return arm;
}

dvrk::ArmSessionOptions session_options(const DvrkRequest& request, const DvrkArm& arm) {
  dvrk::ArmSessionOptions options;
  options.actuator_to_joint = arm.coupling;
  options.rate = request.rate;
  options.mtu = request.mtu;
  options.watchdog = request.watchdog;
  options.announce = request.announce;
  options.firewire = request.firewire;
  options.protocol = request.protocol == "sequential"        ? dvrk::CycleProtocol::kSequential
                     : request.protocol == "broadcast-write" ? dvrk::CycleProtocol::kBroadcastWrite
                     : request.protocol == "broadcast"       ? dvrk::CycleProtocol::kBroadcast
                                                             : dvrk::CycleProtocol::kAutomatic;
  return options;
}

void report_faults(const dvrk::FaultLog& faults) {
  std::istringstream lines(faults.report());
  for (std::string line; std::getline(lines, line);) print_message(line);
}

void add_dvrk_command(CLI::App& tool, Outcome& outcome) {
  CLI::App& dvrk =
      *tool.add_subcommand("dvrk", "Drive, monitor or emulate boards of a da Vinci Research Kit");
  dvrk.require_subcommand(1);
  add_emulate(dvrk, outcome);
  add_monitor_and_read(dvrk, outcome);
  add_run(dvrk, outcome);
  add_dvrk_config(dvrk);
}

}  // namespace veridyn::cli
