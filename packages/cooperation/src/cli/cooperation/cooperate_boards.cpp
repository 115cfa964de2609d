#include "cli/cooperation/cooperate_boards.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>

#include "veridyn/files/output_file.hpp"
#include "veridyn/tool/messages.hpp"
#include "veridyn/tool/option_checks.hpp"
#include "veridyn/tool/stop_signals.hpp"
#include "cooperation/scenario/scenario_models.hpp"
#include "emulator/joined_arms.hpp"
#include "veridyn/dvrk/arms/arm_facts.hpp"
#include "dvrk/cooperation/board_cooperation.hpp"
#include "dvrk/cooperation/board_teleoperation.hpp"
#include "report/json/cooperation_json.hpp"
#include "veridyn/report/json/json_value.hpp"

namespace veridyn::cli {
namespace {

std::string teleoperation_json(const dvrk::TeleoperationRun& run) {
  Json out = json_head("cooperate");
  out["kind"] = "teleoperation";
  out["scenario"] = run.name;
  out["status"] = run.met() ? "done" : "stopped";
  out["reason"] = run.why;
  out["latency"] = run.latency ? Json(*run.latency) : Json();
  out["largest_force"] = run.largest_force;
  out["cycles"] = run.cycles;
  out["late"] = run.late;
  out["power"] = describe(run.power);
  out["phases"] = Json::array();
  for (std::size_t p = 0; p < run.phases.size(); ++p)
    out["phases"].push_back({{"phase", run.phases[p]},
                             {"tracking_rms", run.tracking_rms[p]},
                             {"tracking_largest", run.tracking_largest[p]},
                             {"follower_moved", run.follower_moved[p]},
                             {"force", run.force_follower[p]},
                             {"hand_force", run.force_hand[p]}});
  return json_text(out);
}

// Arm by the path of its configuration, or the nominal one of a known arm.
dvrk::CooperatingArm read_cooperating_arm(const std::string& config) {
  dvrk::CooperatingArm out;
  std::error_code ignored;
  const std::vector<std::string> known = dvrk::arm_names();
  const bool is_file = std::filesystem::is_regular_file(config, ignored);
  if (!is_file) expect_one_of("--boards", config, known);
  const dvrk::IoConfig whole =
      is_file ? dvrk::read_io_config(config) : dvrk::nominal_config(dvrk::read_arm(config));
  out.robot = whole.robot("");
  const std::string& name = is_file ? out.robot.name : config;
  if (std::find(known.begin(), known.end(), name) != known.end())
    out.coupling = dvrk::read_arm(name).coupling();
  return out;
}

// Sets host and port from "HOST[:PORT]"; throws a usage error for another form.
void set_address(const std::string& host, dvrk::CooperatingArm& arm) {
  const auto colon = host.rfind(':');
  arm.host = host.substr(0, colon);
  if (colon == std::string::npos) return;
  char* end = nullptr;
  const long port = std::strtol(host.c_str() + colon + 1, &end, 10);
  expect_value(*end == '\0' && port > 0 && port < 65536, "--board-hosts", "found '", host,
               "', expected HOST or HOST:PORT.");
  arm.port = static_cast<std::uint16_t>(port);
}

// Options of the run; the arms of the request are appended to `arms`.
dvrk::BoardCooperationOptions board_options(const BoardsRequest& request, const Scenario& scenario,
                                            std::vector<dvrk::CooperatingArm>& arms) {
  for (const std::string& config : request.configs) arms.push_back(read_cooperating_arm(config));
  for (std::size_t k = 0; k < request.hosts.size() && k < arms.size(); ++k)
    set_address(request.hosts[k], arms[k]);
  dvrk::BoardCooperationOptions options;
  if (request.emulate) options.emulate = dvrk::emulate_boards;
  options.force_sources = request.sensors;
  options.force_calibrations = request.calibrations;
  options.stepped = request.stepped;
  options.rehearsed = !request.unrehearsed;
  for (const std::string& words : request.faults)
    options.faults.push_back(
        value_of("--board-fault", [&] { return dvrk::parse_emulated_fault(words, scenario); }));
  return options;
}

// JSON of a simulated run, extended by the state of the boards.
std::string boards_json(const dvrk::BoardCooperationRun& done, const Scenario& scenario) {
  nlohmann::ordered_json out = nlohmann::ordered_json::parse(to_json(done.run, scenario));
  const auto arm = [&]() -> nlohmann::ordered_json {
    if (!done.faulty_arm) return nullptr;
    return scenario.arms[*done.faulty_arm].name;
  };
  out["boards"] = {{"done", done.end == dvrk::BoardEnd::kDone},
                   {"reason", done.why},
                   {"arm", arm()},
                   {"fault_at", done.fault_at},
                   {"release_at", done.release_at},
                   {"off_at", done.off_at},
                   {"largest_force_after_fault", done.largest_force_after_fault},
                   {"force_at_release", done.force_at_release},
                   {"force_at_off", done.force_at_off},
                   {"cycles", done.cycles},
                   {"late", done.late},
                   {"power", dvrk::describe(done.power)},
                   {"confirmed_off", done.power == dvrk::OffState::kConfirmed}};
  for (const dvrk::ArmAfterFault& one : done.after_fault)
    out["boards"]["after_fault"].push_back({{"arm", one.name},
                                            {"held", one.held()},
                                            {"answered", one.known},
                                            {"moved", one.moved},
                                            {"rest_after", one.rest_after ? nlohmann::ordered_json(*one.rest_after) : nlohmann::ordered_json()},
                                            {"off_at", one.off_at ? nlohmann::ordered_json(*one.off_at) : nlohmann::ordered_json()}});
  for (const dvrk::LaterFault& one : done.later)
    out["boards"]["later"].push_back({{"at", one.at}, {"what", one.what}});
  out["met"] = done.met();
  return out.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

// Runs a teleoperation of a leader and a follower.
ExitStatus run_teleoperation(const BoardsRequest& request, const std::string& path,
                             const CommonOptions& common, const std::string& output) {
  expect_value(common.report.empty(), "--report", "found a teleoperation, which has no page; see --json and -o");
  const TeleoperationScenario scenario = read_teleoperation(path);
  std::vector<dvrk::CooperatingArm> arms;
  const dvrk::BoardCooperationOptions options = board_options(request, scenario.scenario, arms);
  catch_signals();
  const dvrk::TeleoperationRun done =
      dvrk::teleoperate_on_boards(scenario, arms, options, stop_requested());
  if (!output.empty()) dvrk::write_rows(done, output);
  if (!common.json.empty()) write_file(common.json, teleoperation_json(done));
  std::cout << done.report();
  return done.met() ? kDone : kDataCannotAnswer;
}

}  // namespace

void add_boards_options(CLI::App& command, BoardsRequest& request) {
  add_value(command, "--boards IO...", request.configs,
            "Run on dVRK boards: a configuration (XML, JSON, or PSM1, ...) for each arm");
  add_value(command, "--board-hosts HOST[:PORT]...", request.hosts,
            "Address of the boards of each arm");
  command.add_flag("--emulate", request.emulate,
                   "Emulate the boards over UDP; the emulated arms hold the scenario's object");
  add_value(command, "--force-sensor SOURCE...", request.sensors,
            "Force sensor of each member, then of each wall: serial:... or udp:PORT; three of them "
            "(x, y, z) for a wall's sensor of three axes");
  add_value(command, "--force-calibration FILE...", request.calibrations,
            "Calibration file of each force sensor");
  command.add_flag("--unrehearsed", request.unrehearsed,
                   "Skip the simulation that checks the scenario's requirements before power");
  command.add_flag("--stepped", request.stepped,
                   "With --emulate: simulated time, independent of this machine's speed");
  add_value(command, "--board-fault KIND:ARM@S...", request.faults,
            "With --emulate, a fault: silent, amplifier, power, encoder, jump, limp, weak, "
            "reversed or stuck");
}

std::unique_ptr<LineSource> open_line(const LiveRequest& request) {
  return value_of("--live", [&] { return open_line_source(request.line); });
}

LiveOptions live_options(const LiveRequest& request) {
  LiveOptions options;
  options.pace = request.pace;
  options.silence = request.silence;
  options.watches_silence = request.line != "-";
  return options;
}

LiveReport printing_live_report() {
  LiveReport tell;
  tell.state = [](const std::string& line) { std::cout << line << std::endl; };
  tell.refused = [](const std::string& line) { print_message(line); };
  return tell;
}

ExitStatus run_boards(const BoardsRequest& request, const LiveRequest& live,
                      const Scenario& scenario, const std::string& path, const CommonOptions& common,
                      const std::string& output, const std::string& command_line) {
  expect_value(request.configs.size() == scenario.arms.size(), "--boards", "found ",
               request.configs.size(), " configurations, expected one for each of ",
               scenario.arms.size(), " arms.");
  expect_value(request.emulate || request.hosts.size() == scenario.arms.size(), "--board-hosts",
               "found ", request.hosts.size(), ", expected one for each of ", scenario.arms.size(),
               " arms, or --emulate.");
  for (const std::string& line : assumed_values(scenario))
    if (!common.quiet) print_message(line);
  if (is_teleoperation(path)) {
    expect_value(live.line.empty(), "--live", "found a teleoperation: a hand leads it.");
    return run_teleoperation(request, path, common, output);
  }
  std::vector<dvrk::CooperatingArm> arms;
  dvrk::BoardCooperationOptions options = board_options(request, scenario, arms);
  std::unique_ptr<LineSource> line;
  if (!live.line.empty()) {
    line = open_line(live);
    options.lines = line.get();
    options.live = live_options(live);
    options.live_report = printing_live_report();
  }
  options.rows = output;
  catch_signals();
  const dvrk::BoardCooperationRun done =
      dvrk::run_on_boards(scenario, arms, options, stop_requested());
  if (!output.empty()) write_scenario_rows(done.run, output);
  if (!common.json.empty()) write_file(common.json, boards_json(done, scenario));
  if (!common.report.empty())
    write_file(common.report, to_page(done.run, scenario, command_line));
  std::cout << done.report();
  return done.met() ? kDone : kDataCannotAnswer;
}

}  // namespace veridyn::cli
