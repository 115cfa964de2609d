#pragma once

#include <array>
#include <atomic>
#include <mutex>
#include <thread>
#include <vector>

#include "veridyn/control/cooperative_controller.hpp"
#include "veridyn/cooperation/live.hpp"

namespace veridyn::dvrk {

/// Commands by line for arms on boards. Lines are read, parsed and answered in a thread of their
/// own, or, for boards by a stepped clock, between two cycles; the loop takes commands from a queue
/// and neither waits nor allocates.
class LiveHand {
 public:
  enum class End { kGoesOn, kQuit, kLost };
  enum class Reads { kBeside, kBetweenCycles };

  LiveHand(const Scenario& scenario, LineSource& lines, const LiveOptions& options,
           const LiveReport& report, Reads reads);
  ~LiveHand();
  LiveHand(const LiveHand&) = delete;
  LiveHand& operator=(const LiveHand&) = delete;

  /// Once per cycle: what was asked for goes to the controller. @param time  [s] of the loop.
  End act(double time, CooperativeController& control) noexcept;
  /// What is, for LiveReport::state. @param tips  [m] @param forces  [N] of the members.
  void show(double time, CooperativeState state, const std::vector<Eigen::Vector3d>& tips,
            const std::vector<ForceReading>& forces) noexcept;

  long commands() const { return commands_; }
  long refused() const { return refused_by_words_.load() + refused_; }

 private:
  static constexpr std::size_t kRoom = 64;  // commands on their way to the loop
  struct Shown {
    double time = 0.0;
    CooperativeState state = CooperativeState::kTracking;
    std::vector<Eigen::Vector3d> tips;
    std::vector<ForceReading> forces;
  };

  void pump();
  void say();
  void give(const LiveCommand& command, double time, CooperativeController& control) noexcept;

  const Scenario& scenario_;
  LineSource& lines_;
  LiveOptions options_;
  LiveReport report_;
  Reads reads_;
  std::array<LiveCommand, kRoom> queue_;
  std::atomic<std::size_t> written_{0}, read_{0};
  std::atomic<bool> closed_{false}, ends_{false};
  std::atomic<long> refused_by_words_{0};
  std::mutex showing_;
  Shown shown_;
  bool fresh_ = false;
  long commands_ = 0, refused_ = 0;
  bool began_ = false, jogs_ = false, quits_ = false;
  double heard_ = 0.0, waits_until_ = 0.0, next_jog_ = 0.0, next_show_ = 0.0;
  Eigen::Vector3d velocity_{Eigen::Vector3d::Zero()};
  std::thread thread_;
};

}  // namespace veridyn::dvrk
