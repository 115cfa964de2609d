#pragma once

#include <atomic>
#include <optional>
#include <string>
#include <vector>

#include "veridyn/cooperation/teleoperation_scenario.hpp"
#include "dvrk/cooperation/board_cooperation.hpp"

namespace veridyn::dvrk {

/// Result of a teleoperation on boards.
struct TeleoperationRun {
  std::string name;
  std::vector<std::string> phases;      ///< names; the following have one entry for each
  /// [m] rms distance of the follower's displacement from s R times the leader's, while the clutch is engaged.
  std::vector<double> tracking_rms;
  std::vector<double> tracking_largest;  ///< [m] largest value of this distance
  std::vector<double> follower_moved;   ///< [m] largest displacement of the follower in the phase
  std::vector<double> force_follower;   ///< [N] mean true force of the wall in the last fifth
  std::vector<double> force_hand;       ///< [N] mean force of the leader's tip on the hand there
  /// [s] lag of the follower behind the leader, by a least-squares shift over all phases with the
  /// clutch engaged and without contact, beyond their first 0.06 s; nullopt without such a phase.
  std::optional<double> latency;
  double largest_force = 0.0;  ///< [N] largest force of the wall
  long cycles = 0, late = 0;
  BoardEnd end = BoardEnd::kDone;
  std::string why;        ///< reason in words, if it is not kDone
  double fault_at = 0.0;  ///< [s] time of the fault
  OffState power = OffState::kNotAsked;
  std::vector<ArmAfterFault> after_fault;  ///< see BoardCooperationRun
  std::vector<LaterFault> later;
  std::string not_off;
  MatrixXd rows;  ///< t, leader (3), target (3), follower (3), force, hand (3), clutch
  bool met() const { return end == BoardEnd::kDone; }
  std::string report() const;
};

/// Leader and follower on boards: the leader, with gravity compensated, reflects the follower's force, and
/// the follower follows the leader. On emulated boards a hand moves the leader by the scenario's steps. A
/// fault of either arm makes the follower hold its position, frees the leader, and switches power off after
/// BoardCooperationOptions::hold.
/// @throws InvalidInput  as run_on_boards().
TeleoperationRun teleoperate_on_boards(const TeleoperationScenario& scenario,
                                       const std::vector<CooperatingArm>& arms,
                                       const BoardCooperationOptions& options,
                                       const std::atomic<bool>& stop);

/// Writes the rows as CSV, atomically.
void write_rows(const TeleoperationRun& run, const std::string& path);

}  // namespace veridyn::dvrk
