#include "support/simulated.hpp"
#include "diagnosis/causes/geometry.hpp"
#include "diagnosis/causes/geometry_profiler.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "cli/tool.hpp"
#include "simulation/simulation_support.hpp"
#include "veridyn/simulation/plausible_model.hpp"

// The profile of constants fits the model that identify fits: its effects see the load, the time
// and every sample.

namespace veridyn {
namespace {

struct Case {
  const char* effect;
  std::map<std::string, double> values;
};

class Effects : public testing::TestWithParam<Case> {};

// A recording of an arm with the effect, fitted with its column and without: with it nothing but
// rounding and the filter's edges is left. A column that is zero, or another effect's, leaves as
// much as none.
TEST_P(Effects, AreTheSameColumnsAsInTheSimulation) {
  ModelDescription bare = plausible_model(read_model("elbow-6r"), 4).arm.description();
  bare.effects.clear();
  ModelDescription with = bare;
  EffectTerm term;
  term.effect = GetParam().effect;
  term.axis.coefficients = VectorXd::Unit(6, 1);
  term.values = GetParam().values;
  with.effects.push_back(term);
  const Model arm(with);
  const SimulatedRecording s = simulate_recording(arm, waves(6, 0.6), {});
  Recording r = recording_of(s);
  TemporaryFolder folder;
  const std::string path = folder.path("r.csv");
  write_recording(r, path);
  const double known = GeometryProfiler(arm, {path}, {}).start();
  const double unknown = GeometryProfiler(Model(bare), {path}, {}).start();
  EXPECT_LT(known, unknown - 4.0);  // of the sum of ln(mean square): a seventh of the error at least
}

INSTANTIATE_TEST_SUITE_P(Profile, Effects,
                         testing::Values(Case{"load_dependent_friction", {{"coefficient", 0.1}}},
                                         Case{"warm_up", {{"level", 3.0}, {"time_constant", 5.0}}},
                                         Case{"presliding_hysteresis", {{"level", 3.0}, {"distance", 0.01}}}),
                         [](const auto& test) { return test.param.effect; });

// A length that is 50 mm off on average and differs between recordings: the parts of one recording
// repeat its error, and only whole recordings tell how far the mean of all may be off. For R
// recordings that deviate by d its standard deviation is |d| / sqrt(R (R - 1)); parts that count as
// independent would say a third of it.
TEST(AWrongLength, IsAsUncertainAsItDiffersBetweenRecordings) {
  const Model arm = read_model("planar-2r");
  const std::vector<FrameConstant> constants = row_constants(arm);
  const auto length = std::find_if(constants.begin(), constants.end(), [&](const FrameConstant& c) {
    return c.frame.value == arm.find_frame("upper") && c.number == FrameNumber::kA;
  });
  ASSERT_NE(length, constants.end());
  const std::vector<double> off = {0.03, 0.07, 0.07, 0.03};
  const double deviation = 0.02 * 2.0 / std::sqrt(4.0 * 3.0);
  TemporaryFolder folder;
  std::vector<std::string> paths;
  for (const double by : off) {
    const Model real = with_constant(arm, *length, value_in(arm, *length) + by);
    SimulationOptions exact;
    exact.noise = sensor_noise("none");
    MotionSamples motion = waves(2, 0.6);  // and a second wave: of one alone bodies and lengths look alike
    for (int i = 0; i < 2; ++i) {
      const double w = 5.1 + 0.4 * i;
      const Eigen::ArrayXd angle = w * motion.time.array();
      motion.q.col(i).array() += 0.2 * angle.sin();
      motion.dq.col(i).array() += 0.2 * w * angle.cos();
      motion.ddq.col(i).array() -= 0.2 * w * w * angle.sin();
    }
    const SimulatedRecording s = simulate_recording(real, motion, exact);
    paths.push_back(folder.path(std::to_string(paths.size()) + ".csv"));
    write_recording(recording_of(s), paths.back());
  }
  const std::vector<GeometryFinding> found = profile_geometry(arm, paths, {}, Thresholds());
  const auto mine = std::find_if(found.begin(), found.end(), [&](const GeometryFinding& f) {
    return f.constant.frame.value == length->frame.value && f.stated == value_in(arm, *length);
  });
  ASSERT_NE(mine, found.end()) << found.size();
  EXPECT_NEAR(mine->found - mine->stated, 0.05, 2.0 * deviation);
  EXPECT_GT(mine->deviation, 0.8 * deviation) << mine->found;
  EXPECT_LT(mine->deviation, 4.0 * deviation);
}

// The elbow's torque was not recorded: what acts on it alone is in no residual, and bends nothing.
TEST(AJointWithoutTorque, SaysNothingOfConstants) {
  ModelDescription d = plausible_model(read_model("planar-2r"), 3).arm.description();
  const Model arm(d);
  EffectTerm spring;
  spring.effect = "joint_spring";
  spring.axis.coefficients = VectorXd::Unit(2, 1);
  d.effects.push_back(spring);
  const Model with_spring(std::move(d));
  Recording r = recording_of(simulate_recording(arm, waves_of(1), {}));
  r.tau.col(0).array() += 0.5 * (2.0 * r.q.col(0).array()).sin();  // something is left over
  TemporaryFolder folder;
  const auto start = [&](const Model& of) {
    write_recording(r, folder.path("r.csv"));
    return GeometryProfiler(of, {folder.path("r.csv")}, {}).start();
  };
  EXPECT_GT(std::abs(start(with_spring) - start(arm)), 1e-5);  // of its torque it is a part
  r.tau.col(1).setZero();
  EXPECT_NEAR(start(with_spring), start(arm), 1e-6);
}

}  // namespace
}  // namespace veridyn
