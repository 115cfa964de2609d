#include "veridyn/cooperation/stability.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "loop_search.hpp"
#include "veridyn/cooperation/scenario_run.hpp"
#include "math/parallel.hpp"

namespace veridyn {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kSoftest = 1.0;    // [N/m] of the search over stiffnesses
constexpr double kStiffest = 1e7;
constexpr double kLeastSwing = 0.25;    // [N] from least to largest: more is no noise
constexpr double kSwingShare = 0.1;     // of the wanted force
constexpr double kFirstStep = 1.05, kFarStep = 1.5, kOnsetAccuracy = 1.04;
constexpr int kStiffnessSteps = 56;  // eight per decade

double seconds_since(Clock::time_point begun) {
  return std::chrono::duration<double>(Clock::now() - begun).count();
}

bool has_increments(const Scenario& s) {
  return std::any_of(s.members.begin(), s.members.end(), [](const ScenarioMember& m) {
    return m.law.kind == ForceLaw::Kind::kIncrement;
  });
}

// Modulus per cycle; also above one if an incremental law never comes to rest.
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

// Largest and smallest stiffness of the interval of stable ones that holds the scenario's own; of
// the first one below it, where the scenario's own is not stable.
void find_stiffnesses(const RestPoint& point, const Scenario& scenario, StabilityAnalysis& out) {
  const auto radius = [&](double stiffness) {
    return radius_with_deadbands(point, with_parameter(scenario, "stiffness", stiffness));
  };
  const double own = parameter(scenario, "stiffness");
  double inside = own;
  if (radius(own) > kUnstable) {
    const double step = std::pow(10.0, 0.05);
    inside = own / step;
    while (inside >= kSoftest && radius(inside) > kUnstable) inside /= step;
    if (inside < kSoftest) {
      out.largest_stable_stiffness = out.smallest_stable_stiffness = 0.0;
      out.stiffness_bounded = true;
      return;
    }
  }
  const int steps = has_increments(scenario) ? 14 : kStiffnessSteps;
  const double most = first_crossing(radius, inside, std::max(kStiffest, 10.0 * inside), steps);
  const auto downwards = [&](double ratio) { return radius(inside / ratio); };
  const double least =
      inside / first_crossing(downwards, 1.0, std::max(10.0, inside / kSoftest), steps);
  out.largest_stable_stiffness = std::min(out.largest_stable_stiffness, most);
  out.smallest_stable_stiffness = std::max(out.smallest_stable_stiffness, least);
  out.stiffness_bounded = out.stiffness_bounded || most < kStiffest;
}

// True if the beginning of the scenario does not come to rest in the nonlinear simulation: an arm
// fails, the controller ends it, or the force oscillates by more than a tenth of the wanted one.
bool swings_in_simulation(Scenario scenario) {
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

// Dry friction stills more than the linear loop lets expect: steps upwards, then halves.
void find_simulated_onset(const Scenario& scenario, StabilityAnalysis& out) {
  const bool wanted = !scenario.members.empty() && scenario.bodies.empty() &&
                      out.linear_stable_stiffness > 0.0 && out.linear_stable_stiffness < kStiffest;
  if (!wanted) return;
  const auto swings = [&](double stiffness) {
    ++out.simulated_runs;
    return swings_in_simulation(with_parameter(scenario, "stiffness", stiffness));
  };
  double stable = out.linear_stable_stiffness;
  double unstable = stable * kFirstStep;
  while (!swings(unstable)) {
    stable = unstable;
    unstable *= kFarStep;
    if (unstable > kStiffest) return;
  }
  if (stable == out.linear_stable_stiffness) return;  // friction adds less than a step
  while (unstable > kOnsetAccuracy * stable) {
    const double middle = std::sqrt(stable * unstable);
    (swings(middle) ? unstable : stable) = middle;
  }
  out.largest_stable_stiffness = stable;
}

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
    // A relay looks like any gain up to its describing function's largest.
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

std::string StabilityAnalysis::report() const {
  std::string out = fmt::format(
      "{}: {} at {} points of rest; {} states, eigenvalues of {} cycle{} of {:.4g} ms.\n", name,
      stable ? "stable" : "NOT stable", points.size(), states, cycles, cycles == 1 ? "" : "s",
      1e3 * period);
  out += fmt::format("Worst: {} at {:.4g} s, largest modulus {:.6f} per cycle.\n", worst.phase,
                     worst.time, worst.radius);
  const auto shown = [](double x, const char* unit) {
    return std::isfinite(x) ? fmt::format("{:.3g}{}", x, unit) : std::string("none found");
  };
  out += fmt::format("Margins of the force readings: gain {}, phase {}, delay {}.\n",
                     shown(margins.gain, ""), shown(margins.phase_deg, " degrees"),
                     shown(1e3 * margins.delay, " ms"));
  if (std::isfinite(largest_stable_stiffness))
    out += fmt::format("Object stiffness: stable from {:.4g} up to {:.4g} N/m{}{}.\n",
                       smallest_stable_stiffness, linear_stable_stiffness,
                       stiffness_bounded ? "" : ", the end of the search",
                       simulated_runs > 0
                           ? fmt::format("; with the arms' dry friction up to {:.4g} N/m, by {} "
                                         "simulated run{}",
                                         largest_stable_stiffness, simulated_runs,
                                         simulated_runs == 1 ? "" : "s")
                           : std::string());
  for (const DeadbandSwing& d : deadbands)
    out += fmt::format(
        "{}: increments with a deadband act as an integral of up to {:.3g} m/(N s), and {:.3g} "
        "swings: {}; iterated, {}.\n",
        d.member, d.largest_gain, d.critical_gain,
        d.describing_function_swings ? "a limit cycle may exist" : "no limit cycle",
        d.swings ? fmt::format("it swings by {:.3g} N at {:.3g} Hz", d.amplitude, d.frequency)
                 : std::string("it comes to rest"));
  return out;
}

std::string StabilityStudy::report() const {
  std::string out = analysis.report();
  if (map) {
    const auto stable = std::count(map->stable.begin(), map->stable.end(), 1);
    out += fmt::format("Map of {} and {}: {} of {} points stable, in {:.2g} s.\n", map->a.name,
                       map->b.name, stable, map->stable.size(), map->seconds);
  }
  if (locus) {
    for (std::size_t k = 1; k < locus->values.size(); ++k) {
      if (locus->stable[k] != locus->stable[k - 1])
        out += fmt::format("Locus: {} between {:.4g} and {:.4g}, {}.\n", locus->range.name,
                           locus->values[k - 1], locus->values[k],
                           locus->stable[k] != 0 ? "begins to be stable" : "begins to swing");
    }
  }
  if (recommendation) {
    const GainRecommendation& r = *recommendation;
    out += r.found ? fmt::format(
                         "Recommended for a phase margin of {:.3g} degrees: gain {:.4g} m/(N s), "
                         "proportional {:.4g} m/N, damping {:.4g} s, feed forward {:.4g} m/N, "
                         "impedance damping {:.4g} N s/m; its margins: gain {:.3g}, phase {:.3g} "
                         "degrees.\n",
                         r.phase_deg, r.law.gain, r.law.proportional, r.law.damping,
                         r.law.feed_forward, r.impedance_damping, r.margins.gain,
                         r.margins.phase_deg)
                   : fmt::format("No gains found with a phase margin of {:.3g} degrees.\n",
                                 r.phase_deg);
  }
  if (bounds) {
    const StabilityBounds& b = *bounds;
    out += fmt::format(
        "Bounds: {} of {} corners of the parameters' box ({:.3g} % each) not stable; all corners "
        "are stable up to {:.3g} times these intervals{}. Guaranteed by small gain: errors of the "
        "mass matrix up to {:.2g} % of it.\n",
        b.unstable, b.samples, 1e2 * b.share, b.factor, b.factor_bounded ? "" : " at least",
        1e2 * b.guaranteed_mass_error);
  }
  return out;
}

}  // namespace veridyn
