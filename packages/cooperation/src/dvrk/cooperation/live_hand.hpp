#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "cooperation/motion_plan.hpp"
#include "cooperation/waiting_lines.hpp"
#include "veridyn/control/cooperative_controller.hpp"
#include "veridyn/cooperation/live.hpp"

namespace veridyn::dvrk {

/// Commands by line for arms on boards. Lines are read, parsed and answered in a thread of their own or, for
/// boards with a stepped clock, between two cycles; the loop takes commands from a queue and neither waits
/// nor allocates. Every motion is planned before it is executed, from the present positions: a line that
/// cannot be executed is rejected, and a jog is planned again continuously, so that it stops before an arm
/// reaches a position where it cannot continue. A stop waits only for the plan
/// of the line that is being answered.
class LiveHand {
 public:
  enum class End { kGoesOn, kQuit, kLost };
  enum class Reads { kBeside, kBetweenCycles };

  /// @param plan  null: nothing is planned.
  LiveHand(const Scenario& scenario, LineSource& lines, const LiveOptions& options,
           const LiveReport& report, Reads reads, std::unique_ptr<MotionPlan> plan);
  ~LiveHand();
  LiveHand(const LiveHand&) = delete;
  LiveHand& operator=(const LiveHand&) = delete;

  /// Passes the waiting commands to the controller; once per cycle. @param time  [s] of the loop.
  End act(double time, CooperativeController& control) noexcept;
  /// Stores the state of the loop for LiveReport::state and for plans; in every cycle before act().
  /// @param joints  calls back with the index of each arm and gives its (n) positions.
  template <typename Joints>
  void show(double time, const CooperativeController& control, const CooperativeInput& seen,
            Joints&& joints) noexcept {
    if (!showing_.try_lock()) return;
    shown_.time = time;
    if (!shown_.plan) {
      shown_.plan.emplace(MotionPlan::State{control, seen, {}, {}, {}, 0.0});
      for (std::size_t k = 0; k < scenario_.arms.size(); ++k) shown_.plan->q.push_back(joints(k));
    } else {
      shown_.plan->control = control;
      shown_.plan->seen = seen;
      for (std::size_t k = 0; k < scenario_.arms.size(); ++k) shown_.plan->q[k] = joints(k);
    }
    shown_.taken = read_.load();
    shown_.waits = time < waits_until_;
    shown_.jogs = jogs_;
    shown_.velocity = velocity_;
    showing_.unlock();
    if (reads_ == Reads::kBetweenCycles) report_state();
  }

  long commands() const { return commands_; }
  long refused() const { return refused_by_words_.load() + refused_; }

 private:
  static constexpr std::size_t kRoom = 64;  // capacity for commands that wait for the loop
  struct Shown {
    double time = 0.0;
    std::optional<MotionPlan::State> plan;
    std::size_t taken = 0;  // number of executed commands
    bool waits = false, jogs = false;
    Eigen::Vector3d velocity{Eigen::Vector3d::Zero()};
  };

  void plan_next_line();
  bool stop_requested(int under_way, double now);  ///< queues a wanted stop, refuses the lines before it; false: no stop
  void plan_line(const std::string& line, const Shown& now);  ///< queues the command, or a LiveAlive if it is rejected
  void put(const LiveCommand& command);  ///< into the queue
  void plan_jog(const Shown& now);
  std::string objection(const LiveCommand& command, const Shown& now);  ///< empty: it can be executed
  Shown shown();  ///< a copy of the state that show() stored
  void report_state();  ///< calls LiveReport::state every LiveOptions::tell seconds
  /// Executes a command at `time` [s]: acts on the controller, or sets velocity_, waits_until_, quits_.
  void apply(const LiveCommand& command, double time, CooperativeController& control) noexcept;

  const Scenario& scenario_;
  WaitingLines lines_;
  LiveOptions options_;
  LiveReport report_;
  Reads reads_;
  std::array<LiveCommand, kRoom> queue_;
  std::atomic<std::size_t> written_{0}, read_{0};
  std::atomic<std::size_t> stop_{0};  // number of commands up to and including the last stop that was executed early
  std::atomic<bool> closed_{false}, ends_{false};
  std::atomic<long> refused_by_words_{0};
  std::mutex showing_;
  Shown shown_;
  std::unique_ptr<MotionPlan> plan_;
  std::optional<double> told_, planned_;  // [s] loop time of the last report, and of the last plan
  std::atomic<double> jog_until_{0.0};   // [s] end of the planned jog
  long commands_ = 0, refused_ = 0;
  bool began_ = false, jogs_ = false, quits_ = false;
  double heard_ = 0.0, waits_until_ = 0.0, next_jog_ = 0.0;
  Eigen::Vector3d velocity_{Eigen::Vector3d::Zero()};
  std::thread thread_;
};

}  // namespace veridyn::dvrk
