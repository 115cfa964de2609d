#include "veridyn/cooperation/stability.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>

#include "loop_search.hpp"
#include "sample_pattern.hpp"
#include "veridyn/cooperation/scenario_run.hpp"
#include "veridyn/math/parallel.hpp"

namespace veridyn {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kLeastSwing = 0.25;    // [N] smallest peak-to-peak force that is not noise
constexpr double kSwingShare = 0.1;     // share of the wanted force above which a swing is an oscillation
constexpr double kFirstStep = 1.05, kFarStep = 1.5, kOnsetAccuracy = 1.04;
constexpr int kStiffnessSteps = 56;  // eight per decade
constexpr double kSameRate = 1e-9;   // relative: rounding

double seconds_since(Clock::time_point begun) {
  return std::chrono::duration<double>(Clock::now() - begun).count();
}

bool has_increments(const Scenario& s) {
  return std::any_of(s.members.begin(), s.members.end(), [](const ScenarioMember& m) {
    return m.law.kind == ForceLaw::Kind::kIncrement;
  });
}

// Spectral radius per cycle; it is also above one if an incremental force law never comes to rest.
double radius_with_deadbands(const RestPoint& point, const Scenario& scenario) {
  const double linear = loop_radius(point.loop, scenario);
  if (linear > kUnstable || !has_increments(scenario)) return linear;
  for (size_t k = 0; k < scenario.members.size(); ++k) {
    if (scenario.members[k].law.kind != ForceLaw::Kind::kIncrement) continue;
    if (deadband_swing(point.loop, scenario, static_cast<int>(k)).swings)
      return 1.0 + 1e-6;
  }
  return linear;
}

// The first stiffness with a stable loop, in steps of 12 % from the scenario's own: downwards, and upwards if
// all below are unstable.
std::optional<double> first_stable(const std::function<double(double)>& radius, double own) {
  if (radius(own) <= kUnstable) return own;
  const double step = std::pow(10.0, 0.05);
  for (double at = own / step; at >= kSoftest; at /= step) {
    if (radius(at) <= kUnstable) return at;
  }
  for (double at = own * step; at <= kStiffest; at *= step) {
    if (radius(at) <= kUnstable) return at;
  }
  return std::nullopt;
}

// Largest and smallest stiffness of the stable interval that contains the scenario's own; if that is
// unstable, of the nearest interval below it, or else above it.
void find_stiffnesses(const RestPoint& point, const Scenario& scenario, StabilityAnalysis& out) {
  const auto radius = [&](double stiffness) {
    return radius_with_deadbands(point, with_parameter(scenario, "stiffness", stiffness));
  };
  out.largest_stable_stiffness = out.smallest_stable_stiffness = 0.0;
  out.stiffness_bounded = true;
  const std::optional<double> inside = first_stable(radius, parameter(scenario, "stiffness"));
  if (!inside) return;
  const int steps = has_increments(scenario) ? 14 : kStiffnessSteps;
  out.largest_stable_stiffness = first_crossing(radius, *inside, std::max(kStiffest, 10.0 * *inside), steps);
  const auto downwards = [&](double ratio) { return radius(*inside / ratio); };
  out.smallest_stable_stiffness =
      *inside / first_crossing(downwards, 1.0, std::max(10.0, *inside / kSoftest), steps);
  out.stiffness_bounded = out.largest_stable_stiffness < kStiffest;
}

// True if the beginning of the scenario does not come to rest in the nonlinear simulation: an arm fails, the
// controller ends the task, or the force oscillates by more than a tenth of the wanted one.
bool oscillates_in_simulation(Scenario scenario) {
  scenario.phases.resize(std::min<std::size_t>(scenario.phases.size(), 2));
  scenario.faults.clear();
  scenario.sweep = {};
  const ScenarioRun run = run_scenario(scenario);
  if (!run.complete() || run.state != CooperativeState::kTracking) return true;
  for (const PhaseFigures& phase : run.phases) {
    for (const MemberFigures& m : phase.members) {
      if (m.tracked && m.oscillation > std::max(kLeastSwing, kSwingShare * std::abs(m.wanted)))
        return true;
    }
  }
  return false;
}

// Sets largest_stable_stiffness: dry friction stabilises more than the linear loop. Stiffness in steps, then bisection.
void find_simulated_onset(const Scenario& scenario, StabilityAnalysis& out) {
  const bool wanted = !scenario.members.empty() && scenario.bodies.empty() &&
                      out.linear_stable_stiffness > 0.0 && out.linear_stable_stiffness < kStiffest;
  if (!wanted) return;
  const auto swings = [&](double stiffness) {
    ++out.simulated_runs;
    return oscillates_in_simulation(with_parameter(scenario, "stiffness", stiffness));
  };
  double stable = out.linear_stable_stiffness;
  double unstable = stable * kFirstStep;
  while (!swings(unstable)) {
    stable = unstable;
    if (stable >= kStiffest) {
      out.largest_stable_stiffness = stable;
      return;
    }
    unstable = std::min(unstable * kFarStep, kStiffest);
  }
  if (stable == out.linear_stable_stiffness) return;  // friction adds less than a step
  while (unstable > kOnsetAccuracy * stable) {
    const double middle = std::sqrt(stable * unstable);
    (swings(middle) ? unstable : stable) = middle;
  }
  out.largest_stable_stiffness = stable;
}

// Sensors whose rate differs in the analysis.
std::vector<ReplacedRate> replaced_rates(const Scenario& scenario) {
  const double rate = scenario.control.rate;
  std::vector<ReplacedRate> sensors;
  for (const ScenarioMember& m : scenario.members) sensors.push_back({m.name, m.sensor.rate, 0.0});
  for (const ScenarioWall& w : scenario.walls) sensors.push_back({w.name, w.sensor.rate, 0.0});
  std::vector<double> samples;
  for (const ReplacedRate& s : sensors) samples.push_back(s.rate / rate);
  const SamplePattern pattern = sample_pattern(samples);
  std::vector<ReplacedRate> out;
  for (size_t k = 0; k < sensors.size(); ++k) {
    sensors[k].analysed = rate * pattern.ratios[k];
    const double wanted = std::min(sensors[k].rate, rate);
    if (std::abs(sensors[k].analysed - wanted) > kSameRate * wanted) out.push_back(sensors[k]);
  }
  return out;
}

// The point with the largest spectral radius of the linear loop.
const RestPoint& worst_of(const std::vector<RestPoint>& points, const Scenario& scenario) {
  const RestPoint* worst = &points.front();
  double largest = -1.0;
  for (const RestPoint& p : points) {
    const double radius = loop_radius(p.loop, scenario);
    if (radius > largest) {
      largest = radius;
      worst = &p;
    }
  }
  return *worst;
}

}  // namespace

StabilityAnalysis analyse_stability(const Scenario& scenario) {
  const auto begun = Clock::now();
  const std::vector<RestPoint> points = rest_points(scenario);
  StabilityAnalysis out;
  out.name = scenario.name;
  out.period = 1.0 / scenario.control.rate;
  out.replaced_rates = replaced_rates(scenario);
  for (const ScenarioMember& m : scenario.members) out.members.push_back(m.name);
  const double infinite = std::numeric_limits<double>::infinity();
  out.margins = {infinite, infinite, infinite};
  const bool coupled = !scenario.members.empty() || !scenario.walls.empty();
  out.largest_stable_stiffness = infinite;
  out.stable = true;
  out.radius = -1.0;
  const RestPoint* worst = &points.front();
  for (const RestPoint& p : points) {
    StabilityPoint at;
    at.phase = p.phase;
    at.time = p.time;
    at.radius = radius_with_deadbands(p, scenario);
    at.stable = at.radius <= kUnstable;
    out.stable = out.stable && at.stable;
    if (at.radius > out.radius) {
      out.radius = at.radius;
      out.worst = at;
      worst = &p;
    }
    out.points.push_back(at);
  }
  const ClosedLoop loop(worst->loop, scenario, {});
  out.cycles = loop.hyperperiod();
  out.states = loop.states();
  out.eigenvalues = eigenvalues(loop.map());
  std::sort(out.eigenvalues.begin(), out.eigenvalues.end(), [](const auto& a, const auto& b) {
    return std::hypot(a.first, a.second) > std::hypot(b.first, b.second);
  });
  for (size_t k = 0; k < scenario.members.size(); ++k) {
    if (scenario.members[k].law.kind == ForceLaw::Kind::kIncrement)
      out.deadbands.push_back(deadband_swing(worst->loop, scenario, static_cast<int>(k)));
  }
  if (coupled) {
    out.margins = loop_margins(worst->loop, scenario);
    find_stiffnesses(*worst, scenario, out);
    out.linear_stable_stiffness = out.largest_stable_stiffness;
    find_simulated_onset(scenario, out);
    // A relay acts like any gain up to the maximum of its describing function.
    for (const DeadbandSwing& d : out.deadbands) {
      if (d.largest_gain > 0.0)
        out.margins.gain = std::min(out.margins.gain, d.critical_gain / d.largest_gain);
    }
  }
  out.seconds = seconds_since(begun);
  return out;
}

StabilityMap map_stability(const Scenario& scenario, const ParameterRange& a,
                           const ParameterRange& b, int threads) {
  const auto begun = Clock::now();
  const std::vector<RestPoint> points = rest_points(scenario);
  const RestPoint& worst = worst_of(points, scenario);
  StabilityMap out;
  out.a = a;
  out.b = b;
  out.a_values = a.values();
  out.b_values = b.values();
  const std::size_t columns = out.a_values.size();
  out.radius.resize(columns * out.b_values.size());
  out.stable.resize(out.radius.size());
  parallel_for(static_cast<int>(out.b_values.size()), threads, [&](int j) {
    const Scenario row = with_parameter(scenario, b.name, out.b_values[j]);
    for (std::size_t i = 0; i < columns; ++i) {
      const std::size_t k = i + columns * static_cast<size_t>(j);
      out.radius[k] =
          radius_with_deadbands(worst, with_parameter(row, a.name, out.a_values[i]));
      out.stable[k] = out.radius[k] <= kUnstable ? 1 : 0;
    }
  });
  out.seconds = seconds_since(begun);
  return out;
}

RootLocus root_locus(const Scenario& scenario, const ParameterRange& range) {
  const std::vector<RestPoint> points = rest_points(scenario);
  const RestPoint& worst = worst_of(points, scenario);
  RootLocus out;
  out.range = range;
  out.values = range.values();
  for (const double value : out.values) {
    const Scenario changed = with_parameter(scenario, range.name, value);
    const ClosedLoop loop(worst.loop, changed, {});
    auto found = eigenvalues(loop.map());
    std::sort(found.begin(), found.end(), [](const auto& x, const auto& y) {
      return std::hypot(x.first, x.second) > std::hypot(y.first, y.second);
    });
    out.eigenvalues.push_back(std::move(found));
    out.stable.push_back(radius_with_deadbands(worst, changed) <= kUnstable ? 1 : 0);
  }
  return out;
}

}  // namespace veridyn
