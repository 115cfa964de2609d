#pragma once

#include <functional>
#include <vector>

#include "emulator/board_emulator.hpp"
#include "dvrk/boards/board_session.hpp"
#include "emulator/emulated_link.hpp"

namespace veridyn::dvrk {

/// malloc_count() of this binary (its header stands in one source alone); -1: nothing is counted.
long dvrk_malloc_count();

/// A session with emulated boards 6 and 7, in one process, with a clock that tests move.
class Rig {
 public:
  static constexpr double kCycle = 1.0 / 1500.0;
  static constexpr double kLargest = 2000.0;  ///< largest current [bits]

  static BoardSetup setup(int id, int firmware = 8) {
    BoardSetup s;
    s.id = id;
    s.firmware = firmware;
    return s;
  }

  static SessionOptions options(CycleProtocol protocol = CycleProtocol::kAutomatic) {
    SessionOptions o;
    o.bus.boards = {6, 7};
    o.bus.protocol = protocol;
    o.channels.resize(2);
    for (auto& board : o.channels) {
      for (ChannelSafety& c : board) {
        c.used = true;
        c.max_current = kLargest;
      }
    }
    return o;
  }

  explicit Rig(CycleProtocol protocol = CycleProtocol::kAutomatic,
               const std::vector<BoardSetup>& boards = {setup(6), setup(7)})
      : Rig(options(protocol), boards) {}

  explicit Rig(const SessionOptions& how,
               const std::vector<BoardSetup>& boards = {setup(6), setup(7)})
      : emulator(boards, 3), link(emulator), session(link, how) {}

  /// One cycle of the control loop with this current above zero on every channel.
  bool cycle(double bits = 0.0) {
    if (link.now() < next_) link.wait(next_ - link.now());
    next_ = link.now() + kCycle;
    const bool valid = session.update();
    for (int b = 0; b < session.bus().boards(); ++b) {
      for (int c = 0; c < kChannels; ++c) session.set_command(b, c, kZeroCurrent + bits);
    }
    session.commit();
    return valid;
  }

  void cycles(int count, double bits = 0.0) {
    for (int k = 0; k < count; ++k) cycle(bits);
  }

  /// @returns whether power came up; half a second at most.
  bool power_up() {
    if (session.power_on() != nullptr) return false;
    for (int k = 0; k < 750 && session.state() != PowerState::kOn; ++k) cycle();
    return session.state() == PowerState::kOn;
  }

  bool bring_up() {
    session.start();
    cycles(5);
    return power_up();
  }

  /// Does any motor of the emulator get a current?
  bool currents_flow() {
    for (int b = 0; b < emulator.boards(); ++b) {
      for (int c = 0; c < kChannels; ++c) {
        if (emulator.board(b).drive(c).bits != 0.0) return true;
      }
    }
    return false;
  }

  bool any_amp_on() {
    for (int b = 0; b < emulator.boards(); ++b) {
      for (int c = 0; c < kChannels; ++c) {
        if (emulator.board(b).amp_on(c)) return true;
      }
    }
    return false;
  }

  long count(Condition condition) const { return session.faults().count(condition); }

  BoardEmulator emulator;
  EmulatedLink link;
  BoardSession session;

 private:
  double next_ = 0.0;
};

}  // namespace veridyn::dvrk
