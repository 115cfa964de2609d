#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <set>

#include "dvrk_request.hpp"
#include "messages.hpp"
#include "option_checks.hpp"
#include "veridyn/dvrk/board_server.hpp"
#include "veridyn/dvrk/real_time.hpp"
#include "veridyn/dvrk/run_json.hpp"
#include "veridyn/dvrk/simulated_arm.hpp"
#include "math/output_file.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/model/model_file.hpp"
#include "veridyn/simulation/plant.hpp"

namespace veridyn::cli {
namespace {

using dvrk::BoardEmulator;

/// Something that happens to the boards at a time.
struct Event {
  std::string what;
  int board = -1;
  int axis = -1;
  double time = 0.0;
};

Event parse_event(const std::string& words) {
  Event event;
  const auto at = words.rfind('@');
  const auto colon = words.find(':');
  event.what = words.substr(0, std::min(at, colon));
  int used = 0;
  const bool timed = at != std::string::npos &&
                     std::sscanf(words.c_str() + at, "@%lf%n", &event.time, &used) == 1 &&
                     words[at + static_cast<size_t>(used)] == '\0' && event.time >= 0.0;
  if (colon != std::string::npos)
    std::sscanf(words.c_str() + colon, ":%d.%d", &event.board, &event.axis);
  static const std::set<std::string> kPlain = {"emergency-stop", "release",   "supply-off",
                                               "supply-on",      "bus-reset", "silence"};
  const bool plain = kPlain.count(event.what) != 0 && colon == std::string::npos;
  const bool of_board = event.what == "reboot" && event.board >= 0;
  const bool of_axis = event.what == "amp-fault" && event.board >= 0 && event.axis >= 0 &&
                       event.axis < dvrk::kChannels;
  if (!timed || (!plain && !of_board && !of_axis))
    throw CLI::ValidationError("--event",
                               "found '" + words + "', expected an event as --help has it");
  return event;
}

int place_of(const BoardEmulator& emulator, int id) {
  for (int b = 0; b < emulator.boards(); ++b) {
    if (const_cast<BoardEmulator&>(emulator).board(b).setup().id == id) return b;
  }
  throw CLI::ValidationError("--event", text("board ", id, " is not emulated"));
}

void happen(const Event& event, BoardEmulator& emulator) {
  if (event.what == "emergency-stop") emulator.chain.emergency_stop = true;
  if (event.what == "release") emulator.chain.emergency_stop = false;
  if (event.what == "supply-off") emulator.chain.supply_on = false;
  if (event.what == "supply-on") emulator.chain.supply_on = true;
  if (event.what == "bus-reset") emulator.bus_reset();
  if (event.what == "silence") {
    emulator.faults.reply = dvrk::ReplyFault::kDrop;
    emulator.faults.replies = -1;
  }
  if (event.what == "reboot")
    emulator.board(place_of(emulator, event.board)).reboot(emulator.time());
  if (event.what == "amp-fault")
    emulator.board(place_of(emulator, event.board)).faults.amp[static_cast<size_t>(event.axis)] =
        true;
}

// Zero where the limits allow it, else the middle of the range.
VectorXd start_of(const DvrkRequest& request, const Model& model) {
  const int n = model.joints();
  if (!request.start.empty()) {
    expect_value(static_cast<int>(request.start.size()) == n, "--start", "found ",
                 request.start.size(), " numbers, expected ", n, ", one per joint of ",
                 model.name());
    for (int j = 0; j < n; ++j) {
      const Coordinate& c = model.coordinates()[static_cast<size_t>(j)];
      const double q = request.start[static_cast<size_t>(j)];
      expect_value(!(q < c.limits.lower || q > c.limits.upper), "--start", "found ", q, " for ",
                   c.name, ", expected ", c.limits.lower, " to ", c.limits.upper, ", its limits");
    }
    return Eigen::Map<const VectorXd>(request.start.data(), n);
  }
  VectorXd q = VectorXd::Zero(n);
  for (int j = 0; j < n; ++j) {
    const Limits& limits = model.coordinates()[static_cast<size_t>(j)].limits;
    if (limits.lower > 0.0 || limits.upper < 0.0) q[j] = 0.5 * (limits.lower + limits.upper);
  }
  return q;
}

std::vector<dvrk::BoardSetup> boards_of(const DvrkArm& arm, int firmware) {
  std::vector<dvrk::BoardSetup> boards;
  for (const int id : dvrk::boards_of(arm.robot)) {
    dvrk::BoardSetup setup;
    setup.id = id;
    setup.firmware = firmware;
    boards.push_back(setup);
  }
  return boards;
}

}  // namespace

ExitStatus run_dvrk_emulate(const DvrkRequest& request) {
  require_writable(request.common.json);
  require_writable(request.config_out);
  expect_needs(*request.command, {{"--start", !request.model.empty(), "--model"}});
  const DvrkArm arm = dvrk_arm(request);
  std::vector<Event> events;
  for (const std::string& words : request.events) events.push_back(parse_event(words));
  std::sort(events.begin(), events.end(),
            [](const Event& a, const Event& b) { return a.time < b.time; });
  const std::vector<dvrk::BoardSetup> boards = boards_of(arm, request.firmware);
  BoardEmulator emulator(boards);
  for (const Event& event : events) {
    if (event.board >= 0) place_of(emulator, event.board);
  }
  std::unique_ptr<Plant> plant;
  std::unique_ptr<dvrk::SimulatedArm> load;
  if (!request.model.empty()) {
    const Model model = read_model(request.model);
    plant = std::make_unique<Plant>(model);
    std::vector<int> ids;
    for (const dvrk::BoardSetup& setup : boards) ids.push_back(setup.id);
    load = std::make_unique<dvrk::SimulatedArm>(*plant, arm.robot, arm.coupling, ids,
                                                start_of(request, model));
  }
  if (!request.config_out.empty()) write_file(request.config_out, dvrk::to_io_xml(arm.config));
  catch_signals();
  dvrk::BoardServer server(emulator, request.port);
  emulator.attach(load.get());
  std::cout << fmt::format("{}: {} boards on UDP port {}, firmware {}{}\n", arm.robot.name,
                           boards.size(), server.port(), request.firmware,
                           plant ? "" : ", nothing moves (no --model)")
            << std::flush;
  dvrk::take_real_time_priority(40);
  size_t next = 0;
  double latest_said = 0.02;
  while (!stop_asked().load()) {
    const double t = static_cast<double>(emulator.time()) / dvrk::kTicksPerSecond;
    if (request.seconds > 0.0 && t > request.seconds) break;
    for (; next < events.size() && events[next].time <= t; ++next) {
      happen(events[next], emulator);
      if (!request.common.quiet) say(fmt::format("{:.3f} s: {}", t, events[next].what));
    }
    server.serve(0.001);
    if (load && load->status() != StepStatus::kOk) {
      say(fmt::format("the simulated arm {} at {:.3f} s; it stands still now.",
                      describe(load->status()), t));
      load.reset();
      emulator.attach(nullptr);
    }
    if (server.latest() > 2.0 * latest_said && !request.common.quiet) {
      latest_said = server.latest();
      say(fmt::format("the simulated arm is {:.0f} ms late", 1e3 * latest_said));
    }
  }
  const BoardEmulator::Counters& counters = emulator.counters();
  std::cout << fmt::format("{} requests, {} malformed, {} dropped\n", counters.requests,
                           counters.malformed, counters.dropped);
  if (!request.common.json.empty())
    write_file(request.common.json, dvrk::to_json(counters, arm.robot.name));
  return kDone;
}

}  // namespace veridyn::cli
