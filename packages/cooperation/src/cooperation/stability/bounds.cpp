#include <algorithm>

#include "loop_search.hpp"
#include "veridyn/math/parallel.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr double kFirstFactor = 0.5, kLargestFactor = 10.0;
constexpr int kFactorHalvings = 12;  // halvings below the first factor
constexpr int kFrequencies = 160;
constexpr int kMostLifted = 24;  // largest number of cycles whose inputs form one dense matrix

// Spectral radius per cycle at a corner of the parameters' box, chosen by its seed; `factor` scales the box.
double sampled_spectral_radius(Scenario scenario, double factor, unsigned seed) {
  scenario.seed = seed;
  scenario.model_error *= factor;
  double worst = 0.0;
  for (const RestPoint& p : rest_points(scenario)) worst = std::max(worst, loop_radius(p.loop, scenario));
  return worst;
}

// Factor on the intervals up to which this corner is stable; zero: it is unstable even with exact parameters.
double stable_factor(const Scenario& scenario, unsigned seed) {
  const auto radius = [&](double factor) { return sampled_spectral_radius(scenario, factor, seed); };
  if (radius(kFirstFactor) <= kUnstable) return first_crossing(radius, kFirstFactor, kLargestFactor, 6);
  if (radius(0.0) > kUnstable) return 0.0;
  double stable = 0.0, unstable = kFirstFactor;
  for (int k = 0; k < kFactorHalvings; ++k) {
    const double middle = 0.5 * (stable + unstable);
    (radius(middle) > kUnstable ? unstable : stable) = middle;
  }
  return stable;
}

}  // namespace

StabilityBounds bound_stability(const Scenario& scenario, int samples, int threads) {
  require(samples >= 1, "bound_stability: found ", samples, " samples, expected at least one.");
  // Points at the ends of the first and the last phase are sufficient.
  Scenario short_one = scenario;
  if (short_one.phases.size() > 2)
    short_one.phases.erase(short_one.phases.begin() + 1, short_one.phases.end() - 1);
  StabilityBounds out;
  out.samples = samples;
  out.share = scenario.model_error;
  std::vector<double> radius(samples), factor(radius);
  parallel_for(samples, threads, [&](int k) {
    const auto seed = static_cast<unsigned>(k + 1);
    const auto i = static_cast<size_t>(k);
    radius[i] = sampled_spectral_radius(short_one, 1.0, seed);
    factor[i] = stable_factor(short_one, seed);
  });
  for (const double r : radius) out.unstable += r > kUnstable ? 1 : 0;
  out.worst_radius = *std::max_element(radius.begin(), radius.end());
  out.factor = *std::min_element(factor.begin(), factor.end());
  out.factor_bounded = out.factor < kLargestFactor;

  // Small gain: the largest singular value over frequency from a missing torque, weighted by M_known^-1/2, to
  // M_known^1/2 y.
  double largest = 0.0;
  Scenario exact = short_one;
  exact.model_error = 0.0;
  for (const RestPoint& p : rest_points(exact)) {
    const bool lifted = ClosedLoop(p.loop, exact, {}).hyperperiod() <= kMostLifted;
    if (!lifted || loop_radius(p.loop, exact) > kUnstable) return out;  // no guarantee
    largest = std::max(largest, torque_error_gain(p.loop, exact, kFrequencies));
  }
  out.guaranteed_mass_error = largest > 0.0 ? 1.0 / largest : 0.0;
  return out;
}

}  // namespace veridyn
