#pragma once

#include <Eigen/Core>
#include <atomic>
#include <optional>
#include <string>

#include "cycle_clock.hpp"
#include "motion_check.hpp"
#include "dvrk/run/rows/row_file.hpp"
#include "dvrk/run/rows/row_keeper.hpp"
#include "set_points.hpp"
#include "dvrk/run/arm_run.hpp"

namespace veridyn::dvrk {

/// One motion from power-up to power-down: the arm approaches the first set point, follows, holds,
/// and is switched off in any case.
class MotionRun {
 public:
  /// @param recorded  number of joints that are recorded. All references must outlive the run.
  MotionRun(ArmSession& arm, DatagramLink& link, const MotionSamples& motion, Eigen::Index recorded,
            MotionController& controller, const MotionCheck& check, const RunOptions& options,
            const std::atomic<bool>& stop);

  /// Call it once.
  RunResult run();

 private:
  template <typename Make>
  bool cycle(Make&& make);
  bool control() noexcept;  ///< sets the torques of this cycle; false: the controller refused
  void reset_controller() noexcept;
  void note_blindness(double now, bool valid) noexcept;  ///< begin [s] and reason of a series of invalid reads
  std::string blindness_text(double now) const;
  bool stays_inside();  ///< false, with the run ended: an actuator leaves its soft limits
  bool follows();  ///< false, with the run ended: a tracking error is too large
  bool end(const std::string& why);  ///< keeps the first reason; returns false
  bool check_reads();  ///< false: the run is over, as for the next ones
  bool power_up();
  void hold_position();  ///< set points are the measured positions
  void rest();  ///< set points without velocity and acceleration
  bool approach();  ///< moves to the first set point and settles
  bool play();  ///< follows the motion and records it
  void hold(double seconds);  ///< keeps the last set points
  OffState power_down();

  ArmSession& arm_;
  DatagramLink& link_;
  RunOptions options_;
  const std::atomic<bool>& stop_;
  Eigen::Index recorded_;  // joints
  SetPoints points_;
  MotionController& controller_;
  const MotionCheck& check_;
  RowKeeper keeper_;
  RowFile file_;
  CycleClock clock_;
  LatchTime latch_;
  JointReference wanted_;
  VectorXd tau_;
  std::optional<double> before_;  // [s] time of the last call for torques
  std::optional<double> blind_since_;  // [s] begin of the first cycle in a row without a valid read
  Condition blindness_ = Condition::kNoReply;  // reason of the last invalid read
  std::string why_, busy_;
  bool looks_ = false;  // true while the boards are read before power-up
};

}  // namespace veridyn::dvrk
