#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "support/simulated.hpp"
#include "cli/tool.hpp"
#include "diagnosis/preparation/diagnosis_state.hpp"
#include "simulation/simulation_support.hpp"
#include "veridyn/simulation/plausible_model.hpp"

namespace veridyn {

/// A simulated arm of two joints with known parameters, and its recordings.
class TwoJointArm : public testing::Test {
 protected:
  TwoJointArm() : truth_(plausible_model(read_model("planar-2r"), 3).arm) {}

  // Several waves of each joint, different in each recording.
  static MotionSamples motion(unsigned seed) {
    MotionSamples m = waves(2, 0.5);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> phase(-M_PI, M_PI);
    for (int i = 0; i < 2; ++i) {
      for (const double w : {0.9 + 0.13 * seed, 2.1 + 0.1 * i, 3.7}) {
        const Eigen::ArrayXd angle = w * m.time.array() + phase(random);
        m.q.col(i).array() += 0.3 * angle.sin();
        m.dq.col(i).array() += 0.3 * w * angle.cos();
        m.ddq.col(i).array() -= 0.3 * w * w * angle.sin();
      }
    }
    return m;
  }

  std::string record(unsigned seed, const std::vector<std::string>& hidden,
                     std::optional<double> velocity_noise = {}) const {
    SimulationOptions options;
    for (const std::string& one : hidden) options.hidden.push_back(parse_hidden_effect(one));
    options.noise = sensor_noise("low");
    if (velocity_noise) options.noise.velocity = {*velocity_noise, *velocity_noise};
    options.seed = seed;
    const SimulatedRecording s = simulate_recording(truth_, motion(seed), options);
    const std::string path = folder_.path("recording" + std::to_string(seed) + ".csv");
    write_recording(recording_of(s), path);
    return path;
  }

  // Baseline of this robot file on four recordings, one held out.
  DiagnosisState investigation(const Model& robot, const std::vector<std::string>& hidden) const {
    DiagnosisState x{robot, {}, {}, {}, {}};
    for (unsigned k = 1; k <= 4; ++k) x.train.push_back(record(k, hidden));
    x.test = {record(5, hidden)};
    x.options.identification.threads = 1;
    EXPECT_TRUE(fit_baseline(x));
    return x;
  }

  static Model without_effects(const Model& arm) {
    ModelDescription d = arm.description();
    d.effects.clear();
    return Model(std::move(d));
  }

  Model truth_;
  TemporaryFolder folder_;
};

}  // namespace veridyn
