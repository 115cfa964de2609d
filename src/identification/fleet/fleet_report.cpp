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

// A heading with the first entries of a list below it; nothing for an empty list.
template <typename Entry, typename Line>
std::string list_text(const std::string& heading, const std::vector<Entry>& all, const Line& line) {
  if (all.empty()) return "";
  std::string out = "\n" + heading + "\n";
  for (std::size_t k = 0; k < std::min(fleets::kShown, all.size()); ++k) out += "  " + line(all[k]) + "\n";
  if (all.size() > fleets::kShown) out += fmt::format("  and {} more\n", all.size() - fleets::kShown);
  return out;
}

std::string counted(std::size_t count, const char* what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
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
  if (outliers.empty()) out += "\nno arm stands out\n";
  out += list_text(fmt::format("{} that stand out", outliers.size()), outliers, [](const FleetOutlier& o) {
    return fmt::format("{}: {} is {:.4g}, the fleet's median {:.4g}; {:+.1f} deviations", o.arm, o.what, o.value, o.median, o.deviations);
  });
  out += list_text(fmt::format("{} of {} arms left out of the shared bodies: bodies of their own explain more of their torques than of the others'",
                               other_bodies.size(), members.size()),
                   other_bodies, [](const FleetLeftOut& o) {
    return fmt::format("{}: {:.2f} % of joint {}'s torque is unexplained with the fleet's bodies, {:.2f} % with its own; {:.1f} deviations", o.arm,
                       100.0 * o.with_fleet, o.joint.value + 1, 100.0 * o.with_own, o.deviations);
  });
  out += list_text(counted(undetermined.size(), "arm") + " left out whose recordings leave the bodies open", undetermined,
                   [](const UndeterminedArm& u) { return u.arm + ": " + u.why; });
  for (const std::string& remark : remarks) out += "remark: " + remark + "\n";
  if (!unusable_recordings.empty()) out += "\n" + counted(unusable_recordings.size(), "file") + " left out\n";
  return out;
}

}  // namespace veridyn
