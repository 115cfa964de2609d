#include "diagnosis/causes/geometry_profiler.hpp"

#include <gtest/gtest.h>

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
  Recording r;
  r.time = s.measured.time;
  r.q = s.measured.q;
  r.dq = s.measured.dq;
  r.tau = s.tau;
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

}  // namespace
}  // namespace veridyn
