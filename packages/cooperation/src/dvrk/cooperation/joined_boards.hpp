#pragma once

#include <atomic>
#include <functional>
#include <memory>

#include "dvrk/cooperation/board_cooperation.hpp"
#include "veridyn/dvrk/protocol/datagram_link.hpp"

namespace veridyn::dvrk {

/// Emulated boards of several arms with one world behind their motors, for the loop over boards.
/// Forces and the hand are accessible from other threads.
class JoinedBoards {
 public:
  virtual ~JoinedBoards() = default;
  virtual std::unique_ptr<DatagramLink> link(int arm) = 0;  ///< new connection to the boards of an arm, from 0
  /// Serves in real time until `stop` is true; not called with a stepped clock.
  virtual void run(const std::atomic<bool>& stop) = 0;

  /// Latest true force of a member [N].
  virtual double tension(int member) const = 0;
  virtual double rate(int member) const = 0;    ///< [m/s] rate of its length
  virtual double largest_force() const = 0;     ///< [N] largest force of any member or wall since the start
  /// True force of a wall on its arm [N] in one channel of its sensor, see wall_channels().
  virtual double true_wall_force(int wall, int channel = 0) const = 0;

  /// A hand holds an arm's tip by a spring and a damper [N/m], [N s/m].
  struct Hand {
    int arm = 0;
    double stiffness = 0.0, damping = 0.0;
  };
  /// Attaches the hand at `place` [m] in the world.
  virtual void attach_hand(const Hand& hand, const Eigen::Vector3d& place) = 0;
  virtual void move_hand_to(const Eigen::Vector3d& place) = 0;  ///< [m] in the world
  virtual Eigen::Vector3d hand_force() const = 0;       ///< [N] force on the arm, in the world

  /// Sets a function that the serving thread calls after each step of the world. Call it before serving.
  virtual void watch(std::function<void(const EmulatedInstant&)> watcher) = 0;
  /// Activates the fault.
  virtual void activate_fault(const EmulatedFault& fault) noexcept = 0;
};

}  // namespace veridyn::dvrk
