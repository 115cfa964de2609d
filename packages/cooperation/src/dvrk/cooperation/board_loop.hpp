#pragma once

#include <algorithm>
#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "board_side.hpp"
#include "cooperation/motion_plan.hpp"
#include "dvrk/cooperation/board_cooperation.hpp"
#include "dvrk/cooperation/joined_boards.hpp"
#include "veridyn/control/load_cell.hpp"

namespace veridyn::dvrk {

/// Several arms on boards, real or emulated, in one cycle: lines, sessions, power, the clock and
/// the first cause of an end.
class BoardLoop {
 public:
  BoardLoop(const BoardLoop&) = delete;
  BoardLoop& operator=(const BoardLoop&) = delete;

 protected:
  /// @throws InvalidInput  as run_on_boards().
  BoardLoop(const Scenario& scenario, const std::vector<CooperatingArm>& arms,
            const BoardCooperationOptions& options, const std::atomic<bool>& stop);
  ~BoardLoop() { end_serving(); }

  /// A sensor on a line, with its name in messages: "udp:5600 of member 'spring'".
  struct Sensor {
    std::string name;
    std::unique_ptr<ForceChannel> channel;
    double rate = 0.0;  ///< [Hz] rate of readings that the scenario assumes
    long jumps = 0;     ///< ForceChannel::jumps() until now
  };
  /// Opens a source; readings that jump by more than forces can are rejected.
  Sensor open_sensor(const std::string& source, const std::string& of, double rate,
                     ForceChannelOptions options = {}) const;
  /// The reading of a sensor under power. Any fault of its channel ends the run: the reading is then marked
  /// as too old.
  ForceReading read_sensor(Sensor& sensor) noexcept;
  /// Cycles without power until every sensor has given good readings for kHeard; age counts from the start.
  /// @throws InvalidInput  a sensor has not after BoardCooperationOptions::sensor_patience.
  void wait_for_sensors(std::vector<Sensor>& sensors);
  static constexpr double kHeard = 0.2;  ///< [s] of good readings that every sensor must give before power-up
  static constexpr double kNever = 1e3;  ///< [s] age of a reading that must not be used

  /// The arms and their joints as measured by the boards, for a plan before power-up.
  std::vector<PlannedArm> planned_arms() const;
  std::vector<VectorXd> initial_state() const;  ///< (n) of each arm; throws InvalidInput without positions
  /// @throws InvalidInput  `why` is not empty: phase p, which begins at that time [s], cannot be
  ///                       carried out.
  void require_feasible(std::size_t p, double begins, const std::string& why) const;

  /// Reads the boards for a while before power-up.
  void read_before_power();
  /// Switches power on; call it after read_before_power(). Sensors are read meanwhile, without a check of their values.
  /// @returns false: cause() has the reason; true: the loop's time restarts at zero.
  bool power_up(std::vector<Sensor>& sensors);
  /// Switches power off everywhere; sets not_off_. @returns the worst state of all boards.
  OffState power_down();
  void end_serving();  ///< ends the thread of emulated boards
  /// [s] by the first arm's link.
  double clock() { return sides_.front()->link().now(); }

  // Reads all arms, calls `work`, writes all arms. The first arm's link provides the time.
  template <typename Work>
  void cycle(Work&& work) {
    double now = clock();
    if (next_ <= 0.0) next_ = now;
    if (now < next_) {
      sides_.front()->link().wait(next_ - now);
      now = clock();
    } else if (now - next_ > period_) {
      ++timing_.late;
      next_ = now;
    }
    dt_ = last_ > 0.0 ? now - last_ : period_;
    last_ = now;
    next_ += period_;
    for (auto& side : sides_) side->read(now);
    now_ = now;
    work();
    for (auto& side : sides_) side->write();
    const double took = clock() - now;
    ++timing_.cycles;
    timing_.longest_cycle = std::max(timing_.longest_cycle, took);
    timing_.mean_cycle += (took - timing_.mean_cycle) / static_cast<double>(timing_.cycles);
    time_ += dt_;
  }

  // Runs cycles for this duration by the clock, since cycles may be late.
  template <typename Work>
  void repeat(double seconds, Work&& work) {
    for (const double until = time_ + seconds; time_ < until;) cycle(work);
  }

  // Stores the first cause (fixed text), which ends the run. @returns false.
  bool fail(const char* why, std::optional<int> arm, BoardEnd end = BoardEnd::kFault) noexcept;
  /// The cause in words, with the arm concerned; empty: none.
  std::string cause() const;
  /// Adds the new faults of arm k to the report; the first of all ends the run.
  /// @returns true if there was one.
  bool collect_faults(std::size_t k) noexcept;
  /// Follows the motion of every arm after a fault; once per cycle.
  void watch_hold() noexcept;
  /// The motion of each arm between the fault and the release of the pretension.
  std::vector<ArmAfterFault> after_fault() const;
  std::vector<LaterFault> later_faults() const;
  bool stopped() const { return stop_.load(std::memory_order_relaxed); }
  void activate_fault() noexcept;  ///< activates the emulated faults that are due

  const Scenario& scenario_;
  BoardCooperationOptions options_;
  double period_;
  std::unique_ptr<JoinedBoards> joined_;
  std::vector<std::unique_ptr<BoardSide>> sides_;
  struct {
    long cycles = 0, late = 0;
    double mean_cycle = 0.0, longest_cycle = 0.0;
  } timing_;
  BoardEnd end_ = BoardEnd::kDone;
  const char* why_ = nullptr;
  std::optional<int> faulty_arm_ = {};
  std::optional<JointIndex> faulty_joint_ = {};
  const Sensor* faulty_sensor_ = nullptr;
  double fault_at_ = 0.0;
  double now_ = 0.0, dt_ = 0.0, time_ = 0.0;
  bool gives_up_ = false;  // the pretension is being released: arms may move
  std::string not_off_;  // arms whose boards did not confirm that they are off

 private:
  void join(const std::vector<CooperatingArm>& arms);  ///< creates emulated boards and begins to serve them
  std::unique_ptr<DatagramLink> link_to(const CooperatingArm& arm, std::size_t k);

  const std::atomic<bool>& stop_;
  std::thread serving_;
  std::atomic<bool> stop_serving_{false};
  double next_ = 0.0, last_ = 0.0;

  struct Watched {
    Eigen::Vector3d from{Eigen::Vector3d::Zero()};
    double moved = 0.0, at_fault = 0.0;  // [m] displacement; speed at the fault as a share of the velocity limits
    std::optional<double> rest, off;     // [s] duration from the fault to rest; time of power-off
    bool known = true, began = false;
  };
  struct Later {
    const char* what = nullptr;
    int arm = 0;
    std::optional<JointIndex> joint = {};
    double at = 0.0;
  };
  std::string words(const char* what, int arm, std::optional<JointIndex> joint) const;  ///< "arm NAME: WHAT (joint NAME)"
  /// True if the torques of all arms that share a member with arm k explain the measured forces.
  bool neighbours_explain_force(std::size_t k) const noexcept;
  std::vector<Watched> watched_;
  std::vector<Later> later_;  // reserved in the constructor: the loop does not allocate
};

}  // namespace veridyn::dvrk
