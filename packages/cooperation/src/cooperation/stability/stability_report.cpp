#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "loop_search.hpp"

namespace veridyn {

std::string StabilityAnalysis::report() const {
  std::string out = fmt::format(
      "{}: {} at {} points of rest; {} states, eigenvalues of {} cycle{} of {:.4g} ms.\n", name,
      stable ? "stable" : "NOT stable", points.size(), states, cycles, cycles == 1 ? "" : "s",
      1e3 * period);
  for (const ReplacedRate& r : replaced_rates)
    out += fmt::format("The sensor of {} is analysed with {:.6g} Hz in place of its {:.6g} Hz: samples repeat after at "
                       "most {} cycles then.\n",
                       r.sensor, r.analysed, r.rate, cycles);
  out += fmt::format("Worst: {} at {:.4g} s, largest modulus {:.6f} per cycle.\n", worst.phase,
                     worst.time, worst.radius);
  const auto shown = [](double x, const char* unit) {
    return std::isfinite(x) ? fmt::format("{:.3g}{}", x, unit) : std::string("none found");
  };
  out += fmt::format("Margins of the force readings: gain {}, phase {}, delay {}.\n",
                     shown(margins.gain, ""), shown(margins.phase_deg, " degrees"),
                     shown(1e3 * margins.delay, " ms"));
  if (std::isfinite(largest_stable_stiffness) && linear_stable_stiffness <= 0.0) {
    out += fmt::format("Object stiffness: none from {:.4g} to {:.4g} N/m is stable.\n", kSoftest, kStiffest);
  } else if (std::isfinite(largest_stable_stiffness)) {
    out += fmt::format("Object stiffness: stable from {:.4g} up to {:.4g} N/m{}{}{}.\n",
                       smallest_stable_stiffness, linear_stable_stiffness,
                       stiffness_bounded ? "" : ", the end of the search",
                       stable ? "" : "; as given, the scenario is not stable",
                       simulated_runs > 0
                           ? fmt::format("; with the arms' dry friction up to {:.4g} N/m{}, by {} "
                                         "simulated run{}",
                                         largest_stable_stiffness,
                                         largest_stable_stiffness < kStiffest ? "" : ", the end of the search",
                                         simulated_runs, simulated_runs == 1 ? "" : "s")
                           : std::string());
  }
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
        "are stable up to {:.3g} times these intervals{}.",
        b.unstable, b.samples, 1e2 * b.share, b.factor, b.factor_bounded ? "" : " at least");
    out += b.guaranteed_mass_error > 0.0
               ? fmt::format(" Guaranteed by small gain: errors of the mass matrix up to {:.2g} % of it.\n",
                             1e2 * b.guaranteed_mass_error)
               : std::string(" Small gain guarantees nothing.\n");
  }
  return out;
}

}  // namespace veridyn
