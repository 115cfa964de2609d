#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "identification/fleet/fleet_numbers.hpp"
#include "math/median.hpp"
#include "veridyn/identification/fleet.hpp"

namespace veridyn {
namespace {

double median_error(const Fleet& fleet, Eigen::Index joint, VectorXd FleetMember::*of) {
  std::vector<double> all;
  for (const FleetMember& m : fleet.members) all.push_back((m.*of)[joint]);
  return median(std::move(all));
}

std::string line_of(const FleetOutlier& o) {
  return fmt::format("  {}: {} is {:.4g}, the fleet's median {:.4g}; {:+.1f} deviations\n", o.arm,
                     o.what, o.value, o.median, o.deviations);
}

}  // namespace

std::string Fleet::report() const {
  if (!model) return fmt::format("{}: no fleet: {}.\n", robot, reason);
  std::string out = fmt::format("{}: {} arms, {:.0f} rows, {} base parameters in common\n", robot,
                                members.size(), rows, base.size());
  out += "\nunexplained torque, median over the arms\n";
  for (int i = 0; i < joints; ++i) {
    out += fmt::format("  joint {}: {:.2f} % with the fleet's bodies, {:.2f} % with its own\n",
                       i + 1, 100.0 * median_error(*this, i, &FleetMember::relative_error),
                       100.0 * median_error(*this, i, &FleetMember::alone_error));
  }
  out += "\nwhat each arm has for itself, median and robust spread\n";
  for (const FleetSpread& s : spreads)
    out += fmt::format("  {:<44} {:>12.5g} {:>12.3g} {}\n", s.name, s.median, s.spread, s.unit);
  if (outliers.empty()) {
    out += "\nno arm stands out\n";
  } else {
    out += fmt::format("\n{} that stand out\n", outliers.size());
    for (size_t k = 0; k < std::min(fleets::kShown, outliers.size()); ++k) out += line_of(outliers[k]);
    if (outliers.size() > fleets::kShown)
      out += fmt::format("  and {} more\n", outliers.size() - fleets::kShown);
  }
  if (!other_bodies.empty()) {
    out += fmt::format(
        "\n{} of {} arms left out of the shared bodies: bodies of their own explain more of their "
        "torques than of the others'\n",
        other_bodies.size(), members.size());
    for (size_t k = 0; k < std::min(fleets::kShown, other_bodies.size()); ++k) {
      const FleetLeftOut& o = other_bodies[k];
      out += fmt::format(
          "  {}: {:.2f} % of joint {}'s torque is unexplained with the fleet's bodies, {:.2f} % "
          "with its own; {:.1f} deviations\n",
          o.arm, 100.0 * o.with_fleet, o.joint.value + 1, 100.0 * o.with_own, o.deviations);
    }
    if (other_bodies.size() > fleets::kShown)
      out += fmt::format("  and {} more\n", other_bodies.size() - fleets::kShown);
  }
  if (!undetermined.empty()) {
    out += fmt::format("\n{} left out whose recordings leave the bodies open\n",
                       undetermined.size() == 1 ? "1 arm" : fmt::format("{} arms", undetermined.size()));
    for (size_t k = 0; k < std::min(fleets::kShown, undetermined.size()); ++k)
      out += fmt::format("  {}: {}\n", undetermined[k].arm, undetermined[k].why);
    if (undetermined.size() > fleets::kShown)
      out += fmt::format("  and {} more\n", undetermined.size() - fleets::kShown);
  }
  for (const std::string& remark : remarks) out += "remark: " + remark + "\n";
  if (!unusable_recordings.empty()) out += fmt::format("\n{} left out\n", unusable_recordings.size() == 1 ? "1 file" : fmt::format("{} files", unusable_recordings.size()));
  return out;
}

}  // namespace veridyn
