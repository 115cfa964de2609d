#include <fmt/format.h>

#include <cmath>

#include "veridyn/simulation/breakaway.hpp"

namespace veridyn {

std::string Breakaway::report(const Coordinate& c, const std::string& recording) const {
  std::string out = fmt::format("Breakaway of {} in {}: {} ramps.\n", c.name, recording,
                                events.size());
  const auto level = [&c](double effort) {
    return std::isfinite(effort) ? fmt::format("{:+.3f} {}", effort, effort_unit(c)) : std::string("none");
  };
  // Number of forward and of backward ramps in which the simulated joint stays at rest.
  size_t held[2] = {0, 0};
  size_t ramps[2] = {0, 0};
  for (const BreakawayEvent& e : events) {
    const size_t back = e.direction > 0 ? 0 : 1;
    const bool gave_way = std::isfinite(e.simulated);
    ++ramps[back];
    held[back] += gave_way ? 0 : 1;
    out += fmt::format("  at rest from {:.2f} s: recorded {} at {:.2f} s, simulated {}\n", e.rest_from,
                       level(e.recorded), e.recorded_at,
                       gave_way ? fmt::format("{} at {:.2f} s", level(e.simulated), e.simulated_at)
                                : std::string("did not give way"));
  }
  if (events.empty()) return out;
  const auto median = [&](const char* way, double recorded, double simulated, size_t back) {
    std::string line = fmt::format("median {} recorded {}, simulated {}", way, level(recorded), level(simulated));
    if (held[back] > 0)
      line += fmt::format(" (without {} of {} ramps, at which it did not give way)", held[back], ramps[back]);
    return line + "\n";
  };
  out += median("forwards: ", recorded_forward, simulated_forward, 0);
  out += median("backwards:", recorded_backward, simulated_backward, 1);
  return out;
}

}  // namespace veridyn
