#include <benchmark/benchmark.h>

#include <cmath>

#include "simulation/plant_support.hpp"

// One millisecond of forward dynamics with friction under a PD controller, all joints moving.
// "real_time" is how many times faster than the arm itself that is.

namespace veridyn {
namespace {

constexpr double kStep = 1e-3;

void plant_step(benchmark::State& state, const char* name) {
  const Model arm = robot(name);
  const int n = arm.joints();
  Plant plant(arm);
  const VectorXd home = VectorXd::Constant(n, 0.1);
  plant.set_state(home, VectorXd::Zero(n));
  VectorXd tau(n);
  long k = 0;
  for (auto _ : state) {
    const double t = kStep * static_cast<double>(k++ % 20000);
    for (int i = 0; i < n; ++i) {
      const double wanted = home[i] + 0.2 * std::sin((1.0 + 0.3 * i) * t) * (i == 2 ? 0.2 : 1.0);
      const double stiffness = i > 2 ? 0.5 : 100.0;
      tau[i] = stiffness * ((wanted - plant.q()[i]) - 0.1 * plant.dq()[i]);
    }
    if (plant.step(tau, kStep) != StepStatus::kOk) state.SkipWithError("the plant stopped");
  }
  state.counters["real_time"] =
      benchmark::Counter(kStep * static_cast<double>(k), benchmark::Counter::kIsRate);
  state.counters["substeps"] =
      static_cast<double>(plant.work().taken + plant.work().refused) / static_cast<double>(k);
}
BENCHMARK_CAPTURE(plant_step, psm_3dof, "psm-3dof");
BENCHMARK_CAPTURE(plant_step, psm_wrist, "psm-wrist");
BENCHMARK_CAPTURE(plant_step, ur10e, "ur10e");

}  // namespace
}  // namespace veridyn
