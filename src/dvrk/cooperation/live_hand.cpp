#include "live_hand.hpp"

#include <fmt/format.h>

#include <chrono>

#include "cooperation/phase_commands.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

constexpr double kJogAhead = 0.1;  // [s] that a jog plans ahead
constexpr std::chrono::milliseconds kLook{2};

}  // namespace

LiveHand::LiveHand(const Scenario& scenario, LineSource& lines, const LiveOptions& options,
                   const LiveReport& report, Reads reads)
    : scenario_(scenario), lines_(lines), options_(options), report_(report), reads_(reads) {
  shown_.tips.resize(scenario.arms.size(), Eigen::Vector3d::Zero());
  shown_.forces.resize(scenario.members.size());
  if (reads == Reads::kBetweenCycles) return;
  thread_ = std::thread([this] {
    while (!ends_.load()) {
      pump();
      say();
      std::this_thread::sleep_for(kLook);
    }
  });
}

LiveHand::~LiveHand() {
  ends_.store(true);
  if (thread_.joinable()) thread_.join();
}

// Lines that are there become commands, as far as the queue has room.
void LiveHand::pump() {
  std::string line;
  while (written_.load() - read_.load() < kRoom && lines_.next(line)) {
    LiveCommand command = LiveAlive{};  // also a line that is not understood shows a living hand
    try {
      command = parse_live_command(line, scenario_);
    } catch (const InvalidInput& error) {
      refused_by_words_.fetch_add(1);
      if (report_.refused) report_.refused(error.what());
    }
    queue_[written_.load() % kRoom] = command;
    written_.fetch_add(1);
  }
  if (lines_.closed()) closed_.store(true);
}

void LiveHand::say() {
  Shown now;
  {
    const std::lock_guard<std::mutex> lock(showing_);
    if (!fresh_) return;
    now = shown_;
    fresh_ = false;
  }
  if (!report_.state) return;
  std::string line = fmt::format("t={:.3f} state=\"{}\"", now.time, describe(now.state));
  for (std::size_t k = 0; k < now.tips.size(); ++k)
    line += fmt::format(" {}={:.5f},{:.5f},{:.5f}", scenario_.arms[k].name, now.tips[k].x(),
                        now.tips[k].y(), now.tips[k].z());
  for (std::size_t k = 0; k < now.forces.size(); ++k)
    line += fmt::format(" {}={:.3f}", scenario_.members[k].name, now.forces[k].force);
  report_.state(line);
}

void LiveHand::show(double time, CooperativeState state, const std::vector<Eigen::Vector3d>& tips,
                    const std::vector<ForceReading>& forces) noexcept {
  if (time < next_show_ || !showing_.try_lock()) return;
  next_show_ = time + options_.tell;
  shown_.time = time;
  shown_.state = state;
  shown_.tips = tips;
  for (std::size_t k = 0; k < shown_.forces.size(); ++k) shown_.forces[k] = forces[k];
  fresh_ = true;
  showing_.unlock();
  if (reads_ == Reads::kBetweenCycles) say();
}

void LiveHand::give(const LiveCommand& command, double time,
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
  if (one != nullptr && !give_command(*one, control)) ++refused_;
}

LiveHand::End LiveHand::act(double time, CooperativeController& control) noexcept {
  if (reads_ == Reads::kBetweenCycles && time >= waits_until_) pump();
  // Asked first: what was written before the end came is in the queue then.
  const bool closed = closed_.load();
  while (time >= waits_until_ && !quits_ && read_.load() != written_.load()) {
    give(queue_[read_.load() % kRoom], time, control);
    read_.fetch_add(1);
  }
  if (jogs_ && time - heard_ > options_.silence) {  // a jog needs a living hand
    jogs_ = false;
    control.stop();
  }
  if (jogs_ && time >= next_jog_) {  // short moves, one after the other, keep the velocity
    next_jog_ = time + 0.5 * kJogAhead;
    ScenarioCommand move;
    move.way = velocity_ * 0.5 * kJogAhead;
    move.over = kJogAhead;
    give_command(move, control);
  }
  if (quits_ || time > options_.longest) return End::kQuit;
  const bool silent = options_.watches_silence && began_ && time - heard_ > options_.silence;
  const bool ended = closed && time >= waits_until_ && read_.load() == written_.load();
  return silent || ended ? End::kLost : End::kGoesOn;
}

}  // namespace veridyn::dvrk
