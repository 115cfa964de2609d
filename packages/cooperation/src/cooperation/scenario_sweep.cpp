#include "veridyn/cooperation/scenario_sweep.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>

#include "veridyn/math/parallel.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

std::vector<double> values_or(const std::vector<double>& values, double own) {
  return values.empty() ? std::vector<double>{own} : values;
}

// The scenario with the stiffness, delay and rate of a point, and tuned laws recomputed.
Scenario scenario_at(Scenario scenario, const SweepPoint& point) {
  for (ScenarioMember& member : scenario.members) {
    member.stiffness = member.law.stiffness = point.stiffness;
    member.sensor.delay = point.delay;
  }
  scenario.control.rate = point.rate;
  tune_force_laws(scenario);
  return scenario;
}

// Sets the results of a point from its run.
void evaluate_run(const ScenarioRun& run, double stable_error, SweepPoint& point) {
  bool tracked = false, told = true;
  for (const PhaseFigures& p : run.phases) {
    if (p.asked_force_error > 0.0)
      point.force_error = std::fmax(point.force_error, p.largest_force_error());
    for (const MemberFigures& m : p.members) {
      if (!m.tracked) continue;
      tracked = true;
      told = told && std::isfinite(m.steady_error) && std::isfinite(m.oscillation);
      point.steady_error = std::max(point.steady_error, m.steady_error);
      point.oscillation = std::max(point.oscillation, m.oscillation);
      point.generated = std::max(point.generated, m.generated);
    }
  }
  point.largest_force = run.largest_force;
  if (!run.complete()) point.ended = describe(run.status);
  if (run.state != CooperativeState::kTracking) point.ended = describe(run.state);
  if (point.ended.empty() && !tracked) point.ended = "no force was tracked throughout a phase";
  point.stable = told && point.ended.empty() && point.steady_error <= stable_error &&
                 0.5 * point.oscillation <= stable_error;
}

}  // namespace

const SweepPoint& ScenarioSweepResult::at(std::size_t s, std::size_t d, std::size_t r) const {
  return points.at(s + stiffness.size() * (d + delay.size() * r));
}

double ScenarioSweepResult::stable_delay(std::size_t s, std::size_t r) const {
  double up_to = -1.0;
  for (std::size_t d = 0; d < delay.size() && at(s, d, r).stable; ++d) up_to = delay[d];
  return up_to;
}

double ScenarioSweepResult::largest_generated_where_stable() const {
  double worst = 0.0;
  for (const SweepPoint& p : points) {
    if (p.stable) worst = std::max(worst, p.generated);
  }
  return worst;
}

std::string ScenarioSweepResult::report() const {
  std::string out = fmt::format(
      "{}: {} runs in {:.3g} s. Force error [N] while commands run and after; x where a run is not "
      "stable (more than {:.3g} N at rest).\n",
      name, points.size(), seconds, stable_error);
  for (std::size_t r = 0; r < rate.size(); ++r) {
    out += fmt::format("loop at {:.6g} Hz{:>14}", rate[r], "delay [ms]");
    for (const double d : delay) out += fmt::format("{:>10.3g}", 1e3 * d);
    out += "   stable up to\n";
    for (std::size_t s = 0; s < stiffness.size(); ++s) {
      out += fmt::format("{:>22.6g} N/m   ", stiffness[s]);
      for (std::size_t d = 0; d < delay.size(); ++d) {
        const SweepPoint& p = at(s, d, r);
        out += p.stable ? fmt::format("{:>10.3f}", p.force_error) : fmt::format("{:>10}", "x");
      }
      const double up_to = stable_delay(s, r);
      out += up_to < 0.0 ? "   nowhere\n" : fmt::format("   {:.3g} ms\n", 1e3 * up_to);
    }
  }
  out += fmt::format("Energy made at the object where stable: at most {:.3g} mJ.\n",
                     1e3 * largest_generated_where_stable());
  return out;
}

ScenarioSweepResult sweep_scenario(const Scenario& scenario, const SweepOptions& options) {
  require(scenario.sweep.stable_error > 0.0 && !scenario.members.empty(), "scenario '",
          scenario.name, "': found no sweep over members, expected one.");
  const auto begun = std::chrono::steady_clock::now();
  ScenarioSweepResult out;
  out.name = scenario.name;
  out.engine = options.engine;
  out.stable_error = scenario.sweep.stable_error;
  out.stiffness = values_or(scenario.sweep.stiffness, scenario.members.front().stiffness);
  out.delay = values_or(scenario.sweep.delay, scenario.members.front().sensor.delay);
  out.rate = values_or(scenario.sweep.rate, scenario.control.rate);
  for (const double r : out.rate) {
    for (const double d : out.delay) {
      for (const double s : out.stiffness) {
        SweepPoint point;
        point.stiffness = s;
        point.delay = d;
        point.rate = r;
        out.points.push_back(point);
      }
    }
  }
  std::atomic<int> done{0};
  const auto count = static_cast<int>(out.points.size());
  parallel_for(count, options.threads, [&](int k) {
    SweepPoint& point = out.points[k];
    if (const auto kept = options.kept ? options.kept(k) : std::nullopt) {
      point = *kept;
    } else {
      evaluate_run(run_scenario(scenario_at(scenario, point), options.engine), out.stable_error, point);
      if (options.keep) options.keep(k, point);
    }
    const int now = ++done;
    if (options.progress) options.progress(static_cast<double>(now) / count);
  });
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  return out;
}

}  // namespace veridyn
