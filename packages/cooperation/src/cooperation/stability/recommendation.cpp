#include <algorithm>
#include <cmath>

#include "loop_search.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr double kGainReserve = 1.5;  // factor by which readings may also grow

// The point with the largest spectral radius.
const RestPoint& least_stable_point(const std::vector<RestPoint>& points, const Scenario& scenario) {
  return *std::max_element(points.begin(), points.end(), [&](const auto& a, const auto& b) {
    return loop_radius(a.loop, scenario) < loop_radius(b.loop, scenario);
  });
}

// A law of the form of tuned_force_law() with given crossover [rad/s] and dampings [N s/m].
ForceLaw law_of(const ScenarioMember& m, double crossover, double member_damping,
                double slave_stiffness, double slave_damping) {
  ForceLaw law = tuned_force_law(m.stiffness, slave_stiffness, slave_damping);
  law.gain = crossover / slave_stiffness;
  law.proportional = law.gain * (member_damping + slave_damping) / m.stiffness;
  law.damping = member_damping / slave_stiffness;
  return law;
}

}  // namespace

GainRecommendation recommend_gains(const Scenario& scenario, double phase_deg) {
  const bool gives = std::any_of(
      scenario.members.begin(), scenario.members.end(), [&](const ScenarioMember& m) {
        const auto is = [&](int arm) {
          return arm != scenario.master &&
                 scenario.arms[arm].control == ArmControl::kImpedance;
        };
        return is(m.from) || is(m.to);
      });
  require(gives, "scenario '", scenario.name,
          "': found no member with an impedance at an end, expected one to recommend gains for.");
  const std::vector<RestPoint> points = rest_points(scenario);
  const RestPoint& point = least_stable_point(points, scenario);
  const double stiffness = scenario.control.stiffness.mean();
  const double own_damping = scenario.control.damping.mean();
  const double wanted = phase_deg * M_PI / 180.0;
  GainRecommendation out;
  out.phase_deg = phase_deg;
  Scenario best = scenario;
  for (const double crossover : {100.0, 80.0, 60.0, 45.0, 30.0, 20.0, 12.0, 8.0, 5.0, 3.0}) {
    double smallest = 1.0;
    for (const double impedance : {1.0, 2.0, 4.0, 0.5}) {
      for (const double damping : {120.0, 60.0, 30.0, 200.0, 0.0}) {
        Scenario tried = scenario;
        tried.control.damping *= impedance;
        for (ScenarioMember& m : tried.members) {
          m.tuned = false;
          m.law = law_of(m, crossover, damping, stiffness, own_damping * impedance);
        }
        ++out.tried;
        const double radius = loop_radius(point.loop, tried);
        if (radius >= smallest) continue;
        LoopSettings stronger;
        stronger.reading_gain = kGainReserve;
        if (loop_radius(point.loop, tried, stronger) > kUnstable) continue;
        if (!stable_up_to_phase(point.loop, tried, wanted)) continue;
        smallest = radius;
        best = tried;
        out.found = true;
      }
    }
    if (!out.found) continue;
    out.crossover = crossover;
    out.radius = smallest;
    break;
  }
  out.law = best.members.front().law;
  out.impedance_damping = best.control.damping.mean();
  if (out.found) out.margins = loop_margins(point.loop, best);
  return out;
}

StepResponses step_responses(const Scenario& scenario) {
  const std::vector<RestPoint> points = rest_points(scenario);
  const RestPoint& point = least_stable_point(points, scenario);
  LoopSettings step;
  step.wanted = 1.0;
  const ClosedLoop loop(point.loop, scenario, step);
  StepResponses out;
  const auto count = static_cast<int>(scenario.members.size());
  MatrixXd X = MatrixXd::Zero(loop.states(), 1);
  for (const ScenarioMember& m : scenario.members) out.members.push_back(m.name);
  out.force.resize(out.members.size());
  const long begin = loop.first_cycle();
  const auto steps = static_cast<long>(1.0 * scenario.control.rate);
  const long every = std::max(1L, steps / 1000);
  for (long k = 0; k < steps; ++k) {
    if (k % every == 0) {
      out.time.push_back(static_cast<double>(k) * loop.period());
      for (int m = 0; m < count; ++m)
        out.force[m].push_back(loop.tension_row(m).dot(X.col(0)));
    }
    loop.advance(begin + k, X);
  }
  return out;
}

}  // namespace veridyn
