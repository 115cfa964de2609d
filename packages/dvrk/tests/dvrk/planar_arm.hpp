#pragma once

#include <atomic>
#include <cmath>
#include <functional>

#include "dvrk/run/arm_session.hpp"
#include "emulator/emulated_link.hpp"
#include "emulator/simulated_arm.hpp"
#include "veridyn/math/motion_samples.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/plant.hpp"

namespace veridyn::dvrk {

/// Two motors for planar-2r on board 6; the second is mounted reversed.
inline RobotConfig planar_config() {
  RobotConfig robot;
  robot.name = "planar";
  robot.hardware = "QLA1";
  for (int k = 0; k < 2; ++k) {
    const double sign = k == 0 ? 1.0 : -1.0;
    ActuatorConfig a;
    a.board = 6;
    a.axis = k;
    a.amps_to_bits = {sign * 5242.88, 32768.0 + 40.0 * (k + 1)};
    a.bits_to_amps = {sign * 12.5 / 65536, -sign * 6.25 * (1.0 + 0.004 * k)};
    a.effort_to_amps = 0.06;
    a.max_current = 5.0;
    a.bits_to_position = sign * 2.0 * M_PI / (14400.0 * 56.5);
    a.lower = -2.5;
    a.upper = 2.5;
    a.bits_to_volts = {4.5 / 65536, 0.0};
    a.volts_to_position = {sign * 1.2, -sign * 2.7};
    robot.actuators.push_back(a);
    robot.pot_tolerances.push_back({k, 0.1, 0.01});
  }
  return robot;
}

/// Passes everything on to an emulated link, and calls `each` with the time [s] at the start of
/// every cycle.
class WatchedLink final : public DatagramLink {
 public:
  explicit WatchedLink(BoardEmulator& emulator) : link_(emulator) {}

  bool send(ByteView datagram, Destination to) noexcept override {
    return link_.send(datagram, to);
  }
  Arrival receive(ByteSpan buffer, double timeout) noexcept override {
    return link_.receive(buffer, timeout);
  }
  double now() noexcept override { return link_.now(); }
  void wait(double seconds) noexcept override {
    link_.wait(seconds);
    if (each) each(link_.now());
  }
  std::uint32_t address_word() const noexcept override { return link_.address_word(); }

  std::function<void(double)> each;

 private:
  EmulatedLink link_;
};

/// planar-2r behind one emulated board, in one process.
struct PlanarArm {
  explicit PlanarArm(const Model& real = read_model("planar-2r"),
                     const Eigen::Vector2d& start = {0.4, -0.7})
      : plant(real),
        emulator({setup()}),
        link(emulator),
        load(plant, planar_config(), MatrixXd(), {6}, start) {
    emulator.attach(&load);
  }

  static BoardSetup setup() {
    BoardSetup one;
    one.id = 6;
    return one;
  }

  bool currents_flow() {
    for (int c = 0; c < kChannels; ++c) {
      if (emulator.board(0).drive(c).bits != 0.0) return true;
    }
    return false;
  }

  Plant plant;
  BoardEmulator emulator;
  WatchedLink link;
  SimulatedArm load;
  std::atomic<bool> stop{false};
};

/// A motion of two joints about `middle`, at rest at both ends: the first swings twice, the second
/// three times.
inline MotionSamples swinging(double seconds, const Eigen::Vector2d& middle, double amplitude) {
  const int rows = static_cast<int>(200 * seconds) + 1;
  MotionSamples m;
  m.time.resize(rows);
  m.q.resize(rows, 2);
  m.dq.resize(rows, 2);
  for (int k = 0; k < rows; ++k) {
    const double t = seconds * k / (rows - 1);
    m.time[k] = t;
    for (int j = 0; j < 2; ++j) {
      const double w = 2.0 * M_PI * (2 + j) / seconds;
      m.q(k, j) = middle[j] - amplitude * std::cos(w * t);
      m.dq(k, j) = amplitude * w * std::sin(w * t);
    }
  }
  return m;
}

}  // namespace veridyn::dvrk
