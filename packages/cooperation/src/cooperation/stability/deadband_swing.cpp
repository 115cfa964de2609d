#include <algorithm>
#include <cmath>
#include <limits>

#include "loop_search.hpp"

namespace veridyn {
namespace {

constexpr double kLongest = 12.0;  // [s] simulated duration of the iteration
constexpr double kSettling = 1.0;  // [s] duration from zero force until the law acts
constexpr double kLast = 1.0;      // [s] final interval, in which corrections show whether the loop oscillates

// Smallest integral gain at which the loop oscillates [m/(N s)]; 10 if there is none below.
double critical_gain(const LinearPoint& point, const Scenario& scenario) {
  const auto radius = [&](double gain) {
    LoopSettings s;
    s.increment_gain = gain;
    return loop_radius(point, scenario, s);
  };
  return first_crossing(radius, 1e-5, 10.0, 60);
}

}  // namespace

DeadbandSwing deadband_swing(const LinearPoint& point, const Scenario& scenario, int index) {
  const ScenarioMember& m = scenario.members[index];
  DeadbandSwing out;
  out.member = m.name;
  const double samples = std::min(m.sensor.rate, scenario.control.rate);
  out.largest_gain = m.law.deadband > 0.0
                         ? 2.0 * m.law.increment * samples / (M_PI * m.law.deadband)
                         : std::numeric_limits<double>::infinity();
  out.critical_gain = critical_gain(point, scenario);
  out.describing_function_swings = out.largest_gain > out.critical_gain;

  // x <- A_k (x + e_xf increment), with the reading that arrives in cycle k as a row.
  const ClosedLoop loop(point, scenario, {});
  const int cycles = loop.hyperperiod();
  const long begin = loop.first_cycle();
  std::vector<MatrixXd> A;  // one map for every kind of cycle
  std::vector<VectorXd> readings;
  std::vector<char> fresh;
  for (int k = 0; k < cycles; ++k) {
    if (loop.kinds()[k] == static_cast<int>(A.size())) {
      MatrixXd X = MatrixXd::Identity(loop.states(), loop.states());
      loop.advance(begin + k, X);
      A.push_back(X);
    }
    readings.emplace_back(loop.reading_row(index, begin + k));
    fresh.push_back(loop.has_new_sample(index, begin + k) ? 1 : 0);
  }
  const int row = loop.correction_row(index);
  VectorXd x = VectorXd::Zero(loop.states());
  // The force starts at zero: the correction does not contain the stretch of the member.
  const double start = point.elements[index].force / m.stiffness;
  x[row] = -start;
  const auto settling = static_cast<long>(kSettling * scenario.control.rate) / cycles * cycles;
  for (long k = 0; k < settling; ++k) x = (A[loop.kinds()[k % cycles]] * x).eval();
  const auto steps = static_cast<long>(kLongest * scenario.control.rate);
  const auto last = steps - static_cast<long>(kLast * scenario.control.rate);
  const VectorXd tension = loop.tension_row(index);
  double least = 0.0, most = 0.0;
  int corrections = 0, turns = 0;
  double direction = 0.0;
  for (long k = 0; k < steps; ++k) {
    const auto phase = static_cast<size_t>(k % cycles);
    if (fresh[phase] != 0) {
      const double error = -readings[phase].dot(x);
      if (std::abs(error) > m.law.deadband) {
        const double sign = error < 0.0 ? -1.0 : 1.0;
        x[row] += sign * m.law.increment;
        if (k >= last) {
          ++corrections;
          turns += sign != direction ? 1 : 0;
        }
        direction = sign;
      }
    }
    x = (A[loop.kinds()[phase]] * x).eval();
    const double force = tension.dot(x);
    if (k == last) least = most = force;
    least = std::min(least, force);
    most = std::max(most, force);
    if (k < last) least = most = force;
    if (!x.allFinite()) {  // the loop diverges even without corrections
      out.swings = true;
      out.amplitude = std::numeric_limits<double>::infinity();
      return out;
    }
  }
  out.swings = corrections > 0;
  out.amplitude = 0.5 * (most - least);
  out.frequency = 0.5 * turns / kLast;
  return out;
}

}  // namespace veridyn
