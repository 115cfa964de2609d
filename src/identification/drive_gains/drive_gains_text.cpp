#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

#include "veridyn/identification/drive_gains.hpp"
#include "veridyn/math/require.hpp"
#include "model/suggestion.hpp"

// Parses known masses and reports drive gains.

namespace veridyn {

KnownMass parse_known_mass(const std::string& asked) {
  const auto at = asked.find('@');
  const auto equals = asked.find('=');
  KnownMass out;
  char* end = nullptr;
  const std::string number = asked.substr(0, at);
  out.mass = std::strtod(number.c_str(), &end);
  const bool good = at != std::string::npos && !number.empty() && *end == '\0' && out.mass > 0.0 &&
                    (equals == std::string::npos || equals > at + 1) && at + 1 < asked.size();
  require(good && std::isfinite(out.mass), "known mass: found '", asked,
          "', expected KG@FRAME or KG@FRAME=REC,REC, as 2.8@flange=load.csv.");
  out.frame = asked.substr(at + 1, equals == std::string::npos ? equals : equals - at - 1);
  std::string rest = equals == std::string::npos ? "" : asked.substr(equals + 1) + ",";
  for (size_t comma = rest.find(','); comma != std::string::npos; comma = rest.find(',')) {
    require(comma > 0, "known mass: found no name in '", asked,
            "', expected KG@FRAME=REC,REC with the names of recordings.");
    out.recordings.push_back(rest.substr(0, comma));
    rest = rest.substr(comma + 1);
  }
  return out;
}

std::string DriveGains::report() const {
  std::string out = "drive gains\n";
  for (const MountedLoad& load : loads) {
    std::vector<std::string> names;
    for (const std::string& path : load.known.recordings)
      names.push_back(path.substr(path.find_last_of('/') + 1));
    out += fmt::format("  {:.4g} kg on {} in {}{}", load.known.mass, load.known.frame,
                       listed(names), load.identified ? " (identified)" : "");
    if (load.centre) {
      const Eigen::Vector3d& c = *load.centre;
      const Eigen::Vector3d& s = load.centre_deviation;
      out += fmt::format(", its centre at [{:.3f}, {:.3f}, {:.3f}] m +- [{:.3f}, {:.3f}, {:.3f}]",
                         c.x(), c.y(), c.z(), s.x(), s.y(), s.z());
    }
    out += "\n";
  }
  if (!problem.empty()) return out + "  none: " + problem + "\n";
  for (const DriveGain& g : joints) {
    std::vector<std::string> parts;
    if (std::isfinite(g.low) && std::isfinite(g.high)) {
      parts.push_back(
          fmt::format("{:9.4g} {} (95 %: {:.4g} to {:.4g})", g.value, g.unit, g.low, g.high));
    }
    if (g.in_file != 0.0) parts.push_back(fmt::format("{:.4g} in the robot file", g.in_file));
    if (!g.identifiable) parts.push_back("not identifiable: " + g.reason);
    out += fmt::format("  {:<16} {}\n", g.coordinate, listed(parts));
  }
  return out;
}

}  // namespace veridyn
