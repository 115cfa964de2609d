#pragma once

#include <gtest/gtest.h>

#include <atomic>

#include "dvrk/planar_arm.hpp"
#include "emulator/emulated_link.hpp"
#include "emulator/simulated_arm.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/plant.hpp"

namespace veridyn::dvrk {

/// planar-2r on an emulated board: client, motors and encoders in one process, with a clock of its own.
class PlanarRun : public testing::Test {
 protected:
  static BoardSetup board() {
    BoardSetup setup;
    setup.id = 6;
    return setup;
  }

  PlanarRun()
      : model_(read_model("planar-2r")),
        plant_(model_),
        emulator_({board()}),
        link_(emulator_),
        load_(plant_, planar_config(), MatrixXd(), {6}, Eigen::Vector2d(0.4, -0.7)) {
    emulator_.attach(&load_);
  }

  static MotionSamples motion(double seconds) {
    return swinging(seconds, Eigen::Vector2d(0.1, 0.1), 0.6);
  }

  Model model_;
  Plant plant_;
  BoardEmulator emulator_;
  EmulatedLink link_;
  SimulatedArm load_;
  std::atomic<bool> stop_{false};
};

}  // namespace veridyn::dvrk
