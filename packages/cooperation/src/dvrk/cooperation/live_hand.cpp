#include "live_hand.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "cooperation/phase_commands.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

constexpr double kJogAhead = 0.1;  // [s] planned in advance by a jog
constexpr std::chrono::milliseconds kLook{2};

}  // namespace

LiveHand::LiveHand(const Scenario& scenario, LineSource& lines, const LiveOptions& options,
                   const LiveReport& report, Reads reads, std::unique_ptr<MotionPlan> plan)
    : scenario_(scenario),
      lines_(lines),
      options_(options),
      report_(report),
      reads_(reads),
      plan_(std::move(plan)) {
  require(options.silence > 0.0 && options.longest > 0.0 && options.tell > 0.0,
          "live run: found a time that is not above zero.");
  if (reads == Reads::kBetweenCycles) return;
  thread_ = std::thread([this] {
    while (!ends_.load()) {
      plan_next_line();
      report_state();
      std::this_thread::sleep_for(kLook);
    }
  });
}

LiveHand::~LiveHand() {
  ends_.store(true);
  if (thread_.joinable()) thread_.join();
}

LiveHand::Shown LiveHand::shown() {
  const std::lock_guard<std::mutex> lock(showing_);
  return shown_;
}

// Plans the next line after the loop has executed all earlier ones, from the state that they lead to.
void LiveHand::plan_next_line() {
  const Shown now = shown();
  if (!now.plan) return;
  stop_requested(0, now.time);
  if (now.taken != written_.load()) return;
  if (now.jogs) plan_jog(now);
  std::string line;
  if (!now.waits && lines_.next(line)) plan_line(line, now);
  if (lines_.closed()) closed_.store(true);
}

// A stop is executed before all lines that have not been executed. @param under_way  lines that are being
// processed.
bool LiveHand::stop_requested(int under_way, double now) {
  const std::optional<int> dropped = lines_.stopped(now);
  if (!dropped) return false;
  put(LiveStop{});
  stop_.store(written_.load());
  const int all = *dropped + under_way;
  if (all == 0) return true;
  refused_by_words_.fetch_add(all);
  if (report_.refused) report_.refused(dropped_lines_message(all));
  return true;
}

void LiveHand::put(const LiveCommand& command) {
  queue_[written_.load() % kRoom] = command;
  written_.fetch_add(1);
}

void LiveHand::plan_line(const std::string& line, const Shown& now) {
  LiveCommand command = LiveAlive{};  // an invalid line is a sign of life, too
  try {
    command = parse_live_command(line, scenario_);
    const std::string why = plan_ ? objection(command, now) : "";
    if (stop_requested(1, shown().time)) return;
    if (!why.empty()) throw InvalidInput(text("'", line, "': ", why, "."));
    if (std::holds_alternative<LiveJog>(command)) jog_until_.store(now.time + options_.silence);
  } catch (const InvalidInput& error) {
    command = LiveAlive{};
    refused_by_words_.fetch_add(1);
    if (report_.refused) report_.refused(error.what());
  }
  put(command);
}

std::string LiveHand::objection(const LiveCommand& command, const Shown& now) {
  MotionPlan::State state =
      plan_->state_during_run(now.plan->control, now.plan->seen, now.plan->q);
  if (state.control.state() != CooperativeState::kTracking) return "";  // targets are held: the command is ignored
  if (const auto* jog = std::get_if<LiveJog>(&command))
    return plan_->jog(std::move(state), jog->velocity, options_.silence);
  const auto* one = std::get_if<ScenarioCommand>(&command);
  return one == nullptr ? "" : plan_->check_command(std::move(state), *one);
}

// A jog continues while its motion over the next LiveOptions::silence can be planned.
void LiveHand::plan_jog(const Shown& now) {
  if (!plan_ || (planned_ && now.time < *planned_ + kJogAhead)) return;
  planned_ = now.time;
  const std::string why = objection(LiveJog{now.velocity}, now);
  if (why.empty()) {
    jog_until_.store(now.time + options_.silence);
    return;
  }
  jog_until_.store(0.0);
  if (report_.refused) report_.refused(text("the jog ends: ", why, "."));
}

void LiveHand::report_state() {
  if (!report_.state) return;
  const Shown now = shown();
  if (!now.plan || (told_ && now.time < *told_ + options_.tell)) return;
  told_ = now.time;
  std::string line =
      fmt::format("t={:.3f} state=\"{}\"", now.time, describe(now.plan->control.state()));
  const CooperativeInput& seen = now.plan->seen;
  for (std::size_t k = 0; k < seen.position.size(); ++k)
    line += fmt::format(" {}={:.5f},{:.5f},{:.5f}", scenario_.arms[k].name, seen.position[k].x(),
                        seen.position[k].y(), seen.position[k].z());
  for (std::size_t k = 0; k < seen.force.size(); ++k)
    line += fmt::format(" {}={:.3f}", scenario_.members[k].name, seen.force[k].force);
  report_.state(line);
}

void LiveHand::apply(const LiveCommand& command, double time,
                    CooperativeController& control) noexcept {
  heard_ = time;
  began_ = true;
  if (std::holds_alternative<LiveAlive>(command)) return;
  ++commands_;
  if (std::holds_alternative<LiveQuit>(command)) quits_ = true;
  if (const auto* wait = std::get_if<LiveWait>(&command))
    heard_ = waits_until_ = time + wait->seconds;
  const auto* jog = std::get_if<LiveJog>(&command);
  if (jog != nullptr) velocity_ = jog->velocity;
  if (!std::holds_alternative<LiveWait>(command)) jogs_ = jog != nullptr;
  if (std::holds_alternative<LiveStop>(command)) control.stop();
  const auto* one = std::get_if<ScenarioCommand>(&command);
  if (one != nullptr && !apply_command(*one, control)) ++refused_;
}

LiveHand::End LiveHand::act(double time, CooperativeController& control) noexcept {
  if (reads_ == Reads::kBetweenCycles) plan_next_line();
  if (jogs_ && plan_ && time > jog_until_.load()) {
    jogs_ = false;
    control.stop();
  }
  // Read before the queue: lines before the end of the input are in the queue then.
  const bool closed = closed_.load();
  if (const std::size_t stop = stop_.load(); stop > read_.load()) {
    refused_ += static_cast<long>(stop - 1 - read_.load());
    read_.store(stop - 1);
    waits_until_ = time;
  }
  while (time >= waits_until_ && !quits_ && read_.load() != written_.load()) {
    apply(queue_[read_.load() % kRoom], time, control);
    read_.fetch_add(1);
  }
  if (jogs_ && time - heard_ > options_.silence) {  // a jog needs regular signs of life
    jogs_ = false;
    control.stop();
  }
  if (jogs_ && time >= next_jog_) {  // successive short moves keep the velocity
    next_jog_ = time + 0.5 * kJogAhead;
    ScenarioCommand move;
    move.way = velocity_ * 0.5 * kJogAhead;
    move.over = kJogAhead;
    apply_command(move, control);
  }
  if (quits_ || time > options_.longest) return End::kQuit;
  const bool silent = options_.watches_silence && began_ && time - heard_ > options_.silence;
  const bool ended = closed && time >= waits_until_ && read_.load() == written_.load();
  return silent || ended ? End::kLost : End::kGoesOn;
}

}  // namespace veridyn::dvrk
