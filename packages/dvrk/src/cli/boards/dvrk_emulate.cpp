#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <optional>
#include <set>

#include "veridyn/files/input_file.hpp"
#include "emulator/board_events.hpp"
#include "cli/boards/dvrk_request.hpp"
#include "veridyn/files/output_file.hpp"
#include "veridyn/tool/messages.hpp"
#include "veridyn/tool/option_checks.hpp"
#include "emulator/board_server.hpp"
#include "emulator/emulated_link.hpp"
#include "dvrk/protocol/udp_link.hpp"
#include "veridyn/control/real_time.hpp"
#include "dvrk/run/run_json.hpp"
#include "emulator/simulated_arm.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/engine.hpp"

namespace veridyn::cli {
namespace {

using dvrk::BoardEmulator;

constexpr double kPotNoise = 3.0;      // [bits], standard deviation: 0.2 mV
constexpr double kCurrentNoise = 4.0;  // [bits]: 0.8 mA
constexpr double kStopsBeyond = 0.02;  // distance of end stops from the limits, as a share of a joint's range

/// An emulated arm: its part of a configuration, and the simulation behind it.
struct EmulatedArm {
  DvrkArm of;
  std::unique_ptr<Engine> plant;
  std::unique_ptr<dvrk::SimulatedArm> load;
  bool failed = false;  ///< the failure was reported
};

/// All arms behind the motors of all boards.
class LoadsOfArms final : public dvrk::BoardLoad {
 public:
  explicit LoadsOfArms(const std::vector<EmulatedArm>& arms) {
    for (const EmulatedArm& arm : arms) {
      if (arm.load) loads_.push_back(arm.load.get());
    }
  }
  void advance(double seconds, const dvrk::MotorDrive* drives, dvrk::ChannelMotion* motions,
               std::size_t channels) noexcept override {
    none_.advance(seconds, drives, motions, channels);
    for (dvrk::SimulatedArm* load : loads_) load->advance(seconds, drives, motions, channels);
  }

 private:
  std::vector<dvrk::SimulatedArm*> loads_;
  dvrk::StandingLoad none_;
};

// (n) --start, or zero if it is well inside the limits, else the middle of the range, since an arm at a limit
// cannot be driven.
VectorXd initial_positions(const DvrkRequest& request, const Model& model) {
  const int n = model.joints();
  if (!request.start.empty()) {
    expect_value(static_cast<int>(request.start.size()) == n, "--start", "found ",
                 request.start.size(), " numbers, expected ", n, ", one per joint of ",
                 model.name());
    for (int j = 0; j < n; ++j) {
      const Coordinate& c = model.coordinates()[j];
      const double q = request.start[j];
      expect_value(!(q < c.limits.lower || q > c.limits.upper), "--start", "found ", q, " for ",
                   c.name, ", expected ", c.limits.lower, " to ", c.limits.upper, ", its limits");
    }
    return Eigen::Map<const VectorXd>(request.start.data(), n);
  }
  VectorXd q = VectorXd::Zero(n);
  for (int j = 0; j < n; ++j) {
    const Limits& limits = model.coordinates()[j].limits;
    const double room = kStopsBeyond * (limits.upper - limits.lower);
    if (limits.lower + room > 0.0 || limits.upper - room < 0.0)
      q[j] = 0.5 * (limits.lower + limits.upper);
  }
  return q;
}

// Every robot of the file, or the selected ones; or the known arms, each on its usual boards.
std::vector<EmulatedArm> read_emulated_arms(const DvrkRequest& request) {
  std::vector<DvrkRequest> each;
  DvrkRequest one = request;
  const bool all = !request.config.empty() && request.robot.empty() && request.arms.empty();
  if (all) {
    for (const dvrk::RobotConfig& robot : dvrk::read_io_config(request.config).robots) {
      one.robot = robot.name;
      each.push_back(one);
    }
  } else {
    expect_value(request.config.empty() || request.arms.size() <= 1, "--arm",
                 "expected one arm beside --config");
    for (const std::string& arm : request.arms) {
      one.arm = arm;
      each.push_back(one);
    }
    if (each.empty()) each.push_back(one);
  }
  std::vector<EmulatedArm> arms;
  for (const DvrkRequest& its : each) {
    arms.emplace_back();
    arms.back().of = read_dvrk_arm(its);
    const dvrk::RobotConfig& robot = arms.back().of.robot;
    require(robot.hardware == "QLA1", "robot '", robot.name, "': found hardware ", robot.hardware,
            ", expected QLA1: other boards are not emulated.");
  }
  return arms;
}

// Bytes of the instrument's chip on a board, from --instrument-chip; empty: no chip.
std::vector<std::uint8_t> instrument_chip_bytes(const DvrkRequest& request, int board) {
  for (const std::string& words : request.chips) {
    const auto equals = words.find('=');
    expect_value(equals != std::string::npos, "--instrument-chip", "found '", words,
                 "', expected BOARD=FILE");
    if (words.substr(0, equals) != std::to_string(board)) continue;
    const std::string content = content_of_file(words.substr(equals + 1), "the bytes of an instrument's chip");
    std::vector<std::uint8_t> bytes(content.begin(), content.end());
    require(bytes.size() <= dvrk::kDallasBytes, words.substr(equals + 1), ": found ", bytes.size(),
            " bytes, expected at most ", dvrk::kDallasBytes, ", what an instrument's chip holds.");
    bytes.resize(dvrk::kDallasBytes, 0xFF);
    return bytes;
  }
  return {};
}

// Setups of all boards that the arms use, in the order of their ids.
std::vector<dvrk::BoardSetup> boards_of(const DvrkRequest& request,
                                        const std::vector<EmulatedArm>& arms) {
  std::set<int> ids;
  for (const EmulatedArm& arm : arms) {
    for (const int id : dvrk::boards_of(arm.of.robot)) ids.insert(id);
  }
  std::vector<dvrk::BoardSetup> boards;
  for (const int id : ids) {
    dvrk::BoardSetup setup;
    setup.id = id;
    setup.firmware = request.firmware;
    setup.pot_noise = request.pot_noise.value_or(kPotNoise);
    setup.current_noise = request.current_noise.value_or(kCurrentNoise);
    setup.dallas = instrument_chip_bytes(request, id);
    for (const EmulatedArm& arm : arms) {
      for (const dvrk::BoardSerial& own : arm.of.robot.board_serials)
        if (own.board == id) setup.qla_serial = "QLA " + own.serial;
    }
    setup.io_expander = request.io_expander;
    boards.push_back(setup);
  }
  return boards;
}

// Attaches one model to all arms, or one to each.
void attach_models(const DvrkRequest& request, const std::vector<dvrk::BoardSetup>& boards,
                   std::vector<EmulatedArm>& arms) {
  if (request.models.empty()) return;
  expect_value(request.models.size() == 1 || request.models.size() == arms.size(), "--model",
               "found ", request.models.size(), ", expected one, or one for each of ", arms.size(),
               " arms");
  std::vector<int> ids;
  for (const dvrk::BoardSetup& setup : boards) ids.push_back(setup.id);
  for (size_t k = 0; k < arms.size(); ++k) {
    EmulatedArm& arm = arms[k];
    const Model model = read_model(request.models[request.models.size() == 1 ? 0 : k]);
    arm.plant = make_engine("veridyn", model);
    arm.load = std::make_unique<dvrk::SimulatedArm>(*arm.plant, arm.of.robot, arm.of.coupling, ids,
                                                    initial_positions(request, model));
    arm.load->set_sensors(JointSensors(model));
    VectorXd lower(model.joints()), upper(model.joints());
    for (int j = 0; j < model.joints(); ++j) {
      const Limits& limits = model.coordinates()[j].limits;
      const double range = limits.upper - limits.lower;
      const double beyond = std::isfinite(range) ? kStopsBeyond * range : 0.0;
      lower[j] = limits.lower - beyond;
      upper[j] = limits.upper + beyond;
    }
    arm.load->set_end_stops(lower, upper);
  }
}

// Names of the robots, separated by commas.
std::string names_of(const std::vector<EmulatedArm>& arms) {
  std::string names;
  for (const EmulatedArm& arm : arms) names += (names.empty() ? "" : ", ") + arm.of.robot.name;
  return names;
}

// One configuration with the robots of all arms.
dvrk::IoConfig joined_config(const std::vector<EmulatedArm>& arms) {
  dvrk::IoConfig all = arms.front().of.config;
  all.robots.clear();
  for (const EmulatedArm& arm : arms) all.robots.push_back(arm.of.robot);
  return all;
}

// Reports once the reason for which the simulation of an arm ended; the arm then does not move.
void watch_arms(std::vector<EmulatedArm>& arms, double t) {
  for (EmulatedArm& arm : arms) {
    if (!arm.load || arm.load->status() == StepStatus::kOk || arm.failed) continue;
    arm.failed = true;
    print_message(fmt::format("the simulated arm {} {} at {:.3f} s; it stands still now.", arm.of.robot.name,
                    describe(arm.load->status()), t));
  }
}

// Boards with their arms and events, without a clock.
struct Emulated {
  explicit Emulated(const DvrkRequest& request)
      : arms(read_emulated_arms(request)),
        boards(boards_of(request, arms)),
        emulator(boards),
        events(value_of("--event", [&] { return dvrk::board_events(request.events, emulator); })),
        quiet(request.common.quiet) {
    expect_value(!request.ethernet_only || request.firmware >= 9, "--ethernet-only", "found firmware ",
                 request.firmware, ", expected 9");
    if (request.ethernet_only) emulator.without_firewire();
    attach_models(request, boards, arms);
    load.emplace(arms);
    emulator.attach(&*load);
  }
  double time() const { return static_cast<double>(emulator.time()) / dvrk::kTicksPerSecond; }
  void trigger_event() {
    const double t = time();
    for (; next < events.size() && events[next].time <= t; ++next) {
      events[next].happen(emulator);
      if (!quiet) print_message(fmt::format("{:.3f} s: {}", t, events[next].words));
    }
    watch_arms(arms, t);
  }

  std::vector<EmulatedArm> arms;
  std::vector<dvrk::BoardSetup> boards;
  BoardEmulator emulator;
  std::vector<dvrk::BoardEvent> events;
  std::optional<LoadsOfArms> load;
  std::size_t next = 0;
  bool quiet;
};

// Boards in this process: their clock advances only while the client waits.
class InProcessLink final : public dvrk::DatagramLink {
 public:
  explicit InProcessLink(const DvrkRequest& request) : world_(request), link_(world_.emulator) {}
  bool send(dvrk::ByteView datagram, dvrk::Destination to) noexcept override {
    return link_.send(datagram, to);
  }
  dvrk::Arrival receive(dvrk::ByteSpan buffer, double timeout) noexcept override {
    world_.trigger_event();
    return link_.receive(buffer, timeout);
  }
  double now() noexcept override { return link_.now(); }
  void wait(double seconds) noexcept override {
    world_.trigger_event();
    link_.wait(seconds);
  }
  std::uint32_t address_word() const noexcept override { return link_.address_word(); }

 private:
  Emulated world_;
  dvrk::EmulatedLink link_;
};

}  // namespace

std::unique_ptr<dvrk::DatagramLink> link_to_boards(const DvrkRequest& request) {
  if (!request.emulate) return std::make_unique<dvrk::UdpLink>(request.host, request.port);
  DvrkRequest inside = request;
  inside.robot = read_dvrk_arm(request).robot.name;
  if (request.config.empty()) inside.robot.clear();
  if (!request.model.empty()) inside.models = {request.model};
  return std::make_unique<InProcessLink>(inside);
}

ExitStatus run_dvrk_emulate(const DvrkRequest& request) {
  require_writable(request.common.json, request.config_out);
  expect_prerequisites(*request.command, {{"--start", !request.models.empty(), "--model"}});
  Emulated world(request);
  BoardEmulator& emulator = world.emulator;
  if (!request.config_out.empty()) write_file(request.config_out, dvrk::to_io_xml(joined_config(world.arms)));
  catch_signals();
  dvrk::BoardServer server(emulator, request.port,
                           request.everywhere ? dvrk::BoardServer::Listens::kEverywhere
                                              : dvrk::BoardServer::Listens::kHere);
  std::cout << fmt::format("{}: {} boards on UDP port {}, firmware {}{}\n", names_of(world.arms),
                           world.boards.size(), server.port(), request.firmware,
                           request.models.empty() ? ", nothing moves (no --model)" : "")
            << std::flush;
  set_real_time_priority(40);
  lock_memory();
  double latest_said = 0.02;
  while (!stop_requested().load()) {
    if (request.seconds > 0.0 && world.time() > request.seconds) break;
    world.trigger_event();
    server.serve(0.001);
    if (server.latest() > 2.0 * latest_said && !request.common.quiet) {
      latest_said = server.latest();
      print_message(fmt::format("the simulated arm is {:.0f} ms late", 1e3 * latest_said));
    }
  }
  const BoardEmulator::Counters& counters = emulator.counters();
  std::cout << fmt::format("{} requests ({} writes), {} malformed, {} dropped\n", counters.requests,
                           counters.writes, counters.malformed, counters.dropped);
  if (!request.common.json.empty())
    write_file(request.common.json,
               dvrk::to_json({{"requests", counters.requests},
                              {"malformed", counters.malformed},
                              {"dropped", counters.dropped},
                              {"wrong_crc", counters.wrong_crc},
                              {"writes", counters.writes}},
                             "emulate", names_of(world.arms)));
  return kDone;
}

}  // namespace veridyn::cli
