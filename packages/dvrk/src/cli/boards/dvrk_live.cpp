#include <fmt/format.h>
#include <unistd.h>

#include <iostream>

#include "cli/boards/dvrk_request.hpp"
#include "veridyn/files/output_file.hpp"
#include "veridyn/tool/messages.hpp"
#include "veridyn/control/real_time.hpp"
#include "dvrk/run/run_json.hpp"
#include "dvrk/protocol/udp_link.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::cli {
namespace {

using dvrk::ArmSession;

constexpr double kForever = 1e9;     // [s] duration of a run without --seconds
constexpr double kSilence = 0.5;  // [s] without a valid read, after which the boards count as lost
constexpr double kTableEvery = 0.5;  // [s] between two rows of the table

// Names of the set status flags, separated by commas.
std::string set_flags_text(const dvrk::Status& s) {
  std::string out;
  const auto add = [&](bool set, const char* word) {
    if (set) out += std::string(out.empty() ? "" : ", ") + word;
  };
  add(s.power_requested(), "power");
  add(s.supply_good(), "supply");
  add(s.relay_closed(), "relay");
  add(s.watchdog(), "watchdog");
  add(s.supply_fault(), "supply fault");
  return out.empty() ? "off" : out;
}

// The present state of every joint, one in each row, and the status of the boards.
std::string joint_table(ArmSession& arm) {
  const dvrk::BoardArmState& state = arm.state();
  std::string out = fmt::format("{:>5} {:>12} {:>12} {:>12} {:>10} {:>12} {:>4}\n", "joint",
                                "q [rad, m]", "dq [1/s]", "tau [N m, N]", "i [A]", "pot", "amp");
  for (int j = 0; j < arm.joints(); ++j) {
    const dvrk::BoardFeedback& board = arm.board_of(j);
    const int axis = arm.robot().actuators[j].axis;
    out += fmt::format("{:>5} {:>12.5f} {:>12.5f} {:>12.4f} {:>10.4f} {:>12.5f} {:>4}\n", j + 1,
                       state.q[j], state.dq[j], state.tau[j], state.current[j], state.pot_q[j],
                       board.status.amp_on(axis) ? "on" : "off");
  }
  dvrk::BoardBus& bus = arm.boards().bus();
  for (int b = 0; b < bus.boards(); ++b) {
    const dvrk::BoardFeedback& f = bus.feedback(b);
    out += fmt::format("board {:>2}, firmware {}: {:.1f} C, {:.1f} C; {}\n", bus.info(b).id,
                       bus.info(b).firmware, f.temperature.celsius(0), f.temperature.celsius(1),
                       set_flags_text(f.status));
  }
  return out;
}

// Prints the timing of the loop; for boards in this process only the number of cycles.
void report_timing(const dvrk::LoopTiming& timing, const DvrkRequest& request) {
  if (request.emulate) {
    std::cout << fmt::format("{} cycles by the boards' clock, which stands still while the program computes\n", timing.cycles);
    return;
  }
  const dvrk::WriteGap& gap = timing.longest_gap;
  std::cout << fmt::format("{} cycles, {} late; a cycle took {:.0f} us, at most {:.0f} us\n",
                           timing.cycles, timing.late, 1e6 * timing.mean, 1e6 * timing.longest);
  if (timing.cycles > 1)
    std::cout << fmt::format("longest gap {:.2f} ms, {:.3g} s after the start: {}\n",
                             1e3 * gap.seconds, gap.at, describe_reason(gap));
}

// Options of a command that only reads: it does not home; by registers at no rate of its own.
dvrk::ArmSessionOptions reading_options(const DvrkRequest& request, const DvrkArm& arm,
                                        dvrk::Access access) {
  dvrk::ArmSessionOptions options = session_options(request, arm);
  options.access = access;
  options.homing = dvrk::Homing::kNever;
  if (access == dvrk::Access::kListenByRegister) options.rate = 0.0;
  return options;
}

// With --home loads the encoders in a session of its own. Throws if any motor is on, before anything is
// written, because homing writes "off".
void home_if_requested(const DvrkRequest& request, const DvrkArm& arm, dvrk::UdpLink& link) {
  if (!request.home) return;
  dvrk::require_no_power(link, arm.robot, reading_options(request, arm, dvrk::Access::kListen));
  ArmSession session(link, arm.robot, session_options(request, arm));
  session.start();
}

// Warning if an encoder has not been loaded since power-up; else empty.
std::string missing_preload_warning(ArmSession& session) {
  if (!session.needs_homing()) return "";
  return "the encoders were never loaded: positions count from where the boards woke up (--home "
         "loads them from the pots)";
}

}  // namespace

std::vector<std::string> prepare_loop() {
  std::vector<std::string> refused;
  if (!set_real_time_priority(30))
    refused.push_back("no real-time priority: cycles are late on a busy machine");
  if (!lock_memory()) refused.push_back("memory cannot be locked: a cycle may wait for a page of it");
  return refused;
}

std::string unconfirmed_power_text(dvrk::OffState power) {
  return text("power off is NOT CONFIRMED (", describe(power), "): press the emergency stop");
}

void report_rows(const DvrkRequest& request, const dvrk::RunResult& done) {
  if (done.kept >= done.rows.rows() && done.file_error.empty()) return;
  print_message(fmt::format("{}: {} of {} rows are kept{}{}.", request.output, done.kept, done.rows.rows(),
                  done.file_error.empty() ? "" : ": ", done.file_error));
}

void finish_dvrk(const DvrkRequest& request, const char* command, const dvrk::RunResult& done,
                 const ArmSession& session) {
  report_timing(done.timing, request);
  const dvrk::FaultLog& faults = session.boards().faults();
  report_faults(faults);
  if (!request.common.json.empty())
    write_file(request.common.json, to_json(done, faults, command, session.robot().name));
}

ExitStatus run_dvrk_monitor(const DvrkRequest& request) {
  require_writable(request.common.json);
  const DvrkArm arm = read_dvrk_arm(request);
  dvrk::UdpLink link(request.host, request.port);
  home_if_requested(request, arm, link);
  const bool blocks = request.protocol != "automatic";
  ArmSession session(
      link, arm.robot,
      reading_options(request, arm,
                      blocks ? dvrk::Access::kListen : dvrk::Access::kListenByRegister));
  catch_signals();
  set_real_time_priority(30);
  const bool terminal = ::isatty(STDOUT_FILENO) != 0;
  double next = 0.0;
  double last_read = 0.0;
  const auto show = [&](double t) {
    last_read = t;
    if (t < next) return;
    next = t + kTableEvery;
    if (terminal) std::cout << "\033[H\033[J";
    const std::string loaded = missing_preload_warning(session);
    std::cout << joint_table(session) << loaded << (loaded.empty() ? "" : "\n")
              << session.boards().faults().report() << std::flush;
  };
  const double seconds = request.seconds > 0.0 ? request.seconds : kForever;
  dvrk::RunResult done;
  done.timing = dvrk::watch(session, link, seconds, request.rate, stop_requested(), show);
  done.complete = done.timing.seconds - last_read < kSilence;
  if (!done.complete) done.why = fmt::format("no valid read after {:.3g} s", last_read);
  finish_dvrk(request, "monitor", done, session);
  if (done.complete) return kDone;
  print_message("monitor: " + done.why + ".");
  return kDataCannotAnswer;
}

ExitStatus run_dvrk_read(const DvrkRequest& request) {
  require_writable(request.output, request.common.json);
  const DvrkArm arm = read_dvrk_arm(request);
  dvrk::UdpLink link(request.host, request.port);
  home_if_requested(request, arm, link);
  ArmSession session(link, arm.robot, reading_options(request, arm, dvrk::Access::kListen));
  catch_signals();
  for (const std::string& line : prepare_loop()) print_message(line);
  const dvrk::RunResult done = dvrk::record_at_rest(session, link, request.seconds, request.rate,
                                                    stop_requested(), request.output);
  require(done.rows.rows() > 0, "boards: not a single valid read.");
  std::cout << fmt::format("{}: {} rows, {:.4g} s.\n", arm.robot.name, done.rows.rows(),
                           done.rows.time[done.rows.rows() - 1]);
  const std::string loaded = missing_preload_warning(session);
  if (!loaded.empty()) print_message(loaded);
  finish_dvrk(request, "read", done, session);
  report_rows(request, done);
  if (done.complete) return kDone;
  print_message("read: the recording is incomplete: " + done.why + ".");
  return kDataCannotAnswer;
}

}  // namespace veridyn::cli
