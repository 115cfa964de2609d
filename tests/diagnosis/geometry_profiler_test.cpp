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

}  // namespace
}  // namespace veridyn
