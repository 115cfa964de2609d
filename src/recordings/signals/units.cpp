#include "recordings/signals/units.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <string_view>

#include "files/words.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::recordings {
namespace {

const double kPi = std::acos(-1.0);
/// relative difference of factors that are the same unit
constexpr double kSameFactor = 1e-9;
/// bit of a load register that contains the direction
constexpr long kDirection = 1024;
/// Units of shares, with the number that corresponds to the whole.
constexpr std::pair<const char*, double> kShares[] = {{"%", 100.0}, {"permille", 1000.0}, {"share", 1.0}};

struct Unit {
  const char* signal;
  const char* unit;
  double factor;
};

const Unit kUnits[] = {
    {"q", "rad", 1.0},          {"q", "m", 1.0},
    {"q", "deg", kPi / 180.0},  {"q", "mm", 1e-3},
    {"q", "mrad", 1e-3},        {"q", "rev", 2.0 * kPi},
    {"dq", "rad/s", 1.0},       {"dq", "m/s", 1.0},
    {"dq", "deg/s", kPi / 180.0}, {"dq", "deg", kPi / 180.0},
    {"dq", "mm/s", 1e-3},       {"dq", "mm", 1e-3},
    {"dq", "mrad/s", 1e-3},     {"dq", "rpm", kPi / 30.0},
    {"ddq", "rad/s2", 1.0},     {"ddq", "m/s2", 1.0},
    {"ddq", "deg/s2", kPi / 180.0}, {"ddq", "deg", kPi / 180.0},
    {"ddq", "mm/s2", 1e-3},     {"tau", "Nm", 1.0},
    {"tau", "N", 1.0},          {"tau", "mNm", 1e-3},
    {"tau", "Ncm", 1e-2},       {"tau", "Nmm", 1e-3},
    {"tau", "kNm", 1e3},        {"tau", "kgcm", 0.0980665},
    {"tau", "ozin", 7.0615518e-3}, {"tau", "lbin", 0.11298483},
    {"tau", "A", 1.0},
    {"tau", "mA", 1e-3},        {"i", "A", 1.0},
    {"i", "mA", 1e-3},          {"t", "s", 1.0},
    {"t", "ms", 1e-3},          {"t", "us", 1e-6},
    {"t", "ns", 1e-9},          {"t", "min", 60.0}};

std::string without_sign(const std::string& unit) {
  return unit.substr(starts_with(unit, "-") ? 1 : 0);
}

bool is_share_of_range(const std::string& unit) {
  return std::any_of(std::begin(kShares), std::end(kShares), [&](const auto& share) { return without_sign(unit) == share.first; });
}

bool is_unit_of_other_joint_type(const SignalChoice& choice, const std::string& unit, int joint) {
  return joint >= 1 && static_cast<std::size_t>(joint) <= choice.joints.size() && recordings::is_unit_of_other_joint_type(unit, choice.joints[joint - 1]);
}

// The signal and the number of a key such as `tau1`; number 0: all joints, or one that no arm has.
struct UnitKey {
  std::string signal;
  int joint = 0;
  bool of_one = false;
};

UnitKey unit_key(const std::string& key) {
  const std::size_t digits = key.find_last_not_of("0123456789") + 1;
  const bool of_one = digits < key.size();
  return {key.substr(0, digits), of_one && key.size() - digits <= 6 ? std::stoi(key.substr(digits)) : 0, of_one};
}

}  // namespace

bool is_unit_of_other_joint_type(const std::string& unit, const WantedJoint& joint) {
  const std::string size = without_sign(unit);
  if (!joint.prismatic) return starts_with(size, "mm");
  return starts_with(size, "deg") || starts_with(size, "mrad") || size == "rev" || size == "rpm" || starts_with(size, "rad");
}

std::string unit_name(const std::string& signal, const UnitScale& scale, const WantedJoint& joint) {
  std::string out = text(scale.factor);
  for (const Unit& u : kUnits) {
    if (signal != u.signal || is_unit_of_other_joint_type(u.unit, joint) || std::abs(std::abs(scale.factor) / u.factor - 1.0) > kSameFactor) continue;
    out = (scale.factor < 0.0 ? "-" : "") + std::string(u.unit);
    break;
  }
  return scale.zero == 0.0 ? out : text(out, "@", scale.zero);
}

double UnitScale::operator()(double number) const {
  if (direction_bit && std::isfinite(number)) {
    const auto bits = static_cast<long>(std::clamp(number, 0.0, 2.0 * kDirection));
    return factor * static_cast<double>(bits % kDirection) * (bits >= kDirection ? -1.0 : 1.0);
  }
  return factor * (number - zero);
}

std::optional<UnitScale> unit_scale(const std::string& signal, const std::string& unit, const WantedJoint* joint) {
  if (unit.rfind('-', 0) == 0) {
    std::optional<UnitScale> scale = signal == "t" ? std::nullopt : unit_scale(signal, unit.substr(1), joint);
    if (scale) scale->factor *= -1.0;
    return scale;
  }
  const std::size_t at_zero = unit.find('@');
  if (at_zero != std::string::npos && at_zero > 0 && signal == "q") {
    double zero = 0.0;
    const auto [last, bad] = std::from_chars(unit.data() + at_zero + 1, unit.data() + unit.size(), zero);
    std::optional<UnitScale> scale = bad == std::errc() && last == unit.data() + unit.size() ? unit_scale(signal, unit.substr(0, at_zero), joint) : std::nullopt;
    if (scale) scale->zero += zero;
    return scale;
  }
  for (const Unit& u : kUnits) {
    if (signal == u.signal && unit == u.unit) return UnitScale{u.factor};
  }
  const double upper = joint != nullptr ? joint->upper : 1.0, lower = joint != nullptr ? joint->lower : -1.0;
  const double effort = joint != nullptr ? joint->effort : 1.0;
  for (const auto& [name, parts] : kShares) {
    if (unit != name) continue;
    if (signal == "tau") return UnitScale{effort / parts};
    const double factor = 0.5 * (upper - lower) / parts;
    if (signal == "q") return UnitScale{factor, -0.5 * (lower + upper) / factor};
    return signal == "dq" ? std::optional<UnitScale>(UnitScale{factor}) : std::nullopt;
  }
  if (unit == "load" && signal == "tau") return UnitScale{(std::isfinite(effort) ? effort : 1.0) / (kDirection - 1), 0.0, true};
  double number = 0.0;
  const char* end = unit.data() + unit.size();
  const auto [rest, error] = std::from_chars(unit.data(), end, number);
  if (error != std::errc() || !std::isfinite(number) || number == 0.0) return std::nullopt;
  if (rest == end) return UnitScale{number};
  const std::string_view behind(rest, static_cast<std::size_t>(end - rest));
  if (behind.rfind("/rev", 0) != 0 || (signal != "q" && signal != "dq" && signal != "ddq")) return std::nullopt;
  return behind.size() == 4 ? std::optional<UnitScale>(UnitScale{2.0 * kPi / number}) : std::nullopt;
}

std::optional<double> unit_factor(const std::string& signal, const std::string& unit) {
  const std::optional<UnitScale> scale = unit_scale(signal, unit);
  return scale ? std::optional<double>(scale->factor) : std::nullopt;
}

const char* unit_of_clock(double step) {
  constexpr double kThousand = 1e3;
  return step < kThousand ? "ms" : step < kThousand * kThousand ? "us" : "ns";
}

bool is_current_unit(const std::string& unit) {
  return without_sign(unit) == "A" || without_sign(unit) == "mA";
}

std::string unit_of(const SignalChoice& choice, const std::string& signal, int joint) {
  const auto own = choice.units.find(text(signal, joint));
  if (own != choice.units.end()) return own->second;
  const auto all = choice.units.find(signal);
  return all == choice.units.end() ? std::string() : all->second;
}

UnitScale scale_for(const SignalChoice& choice, const std::string& signal, int joint) {
  const std::string unit = unit_of(choice, signal, joint);
  if (unit.empty() || is_unit_of_other_joint_type(choice, unit, joint)) return {};
  const bool known = joint >= 1 && static_cast<std::size_t>(joint) <= choice.joints.size();
  return unit_scale(signal, unit, known ? &choice.joints[joint - 1] : nullptr).value_or(UnitScale());
}

void require_known_units(const SignalChoice& choice) {
  for (const auto& [key, unit] : choice.units) {
    const std::string signal = unit_key(key).signal;
    std::string known;
    for (const Unit& u : kUnits) {
      if (signal == u.signal) known += (known.empty() ? "" : ", ") + std::string(u.unit);
    }
    require(!known.empty(), "--units: found '", key, "', expected t, q, dq, ddq, tau or i.");
    require(unit_factor(signal, unit).has_value(), "--units: found '", key, "=", unit,
            "', expected one of: ", known, " (with - in front for the other sign), a factor to SI as 0.01",
            signal[0] == 't' && signal != "tau" ? "." : signal == "tau" ? ", a share of the largest effort (%, permille, share), or load."
                                                                        : ", counts as 4096/rev or 4096/rev@2048, or a share of the range (%).");
  }
}

void require_joints_of(const SignalChoice& choice, int joints, const std::string& path) {
  for (int joint = 1; joint <= joints; ++joint) {
    for (const char* signal : {"q", "dq", "tau"}) {
      const UnitScale scale = scale_for(choice, signal, joint);
      const bool shared = static_cast<std::size_t>(joint) <= choice.joints.size();
      require(std::isfinite(scale.factor) && std::isfinite(scale.zero) && (shared || !is_share_of_range(unit_of(choice, signal, joint))), "--units: found '", signal, "=",
              unit_of(choice, signal, joint), "', but joint ", joint, " has no ", signal[0] == 't' ? "limit of effort" : "limits of position",
              ", expected a robot file that gives them.");
    }
  }
  for (const auto& [key, unit] : choice.units) {
    const auto [signal, joint, of_one] = unit_key(key);
    if (!of_one) continue;
    require(joint >= 1 && joint <= joints, "--units: found '", key, "', but ", path, " has ", joints,
            joints == 1 ? " joint." : " joints.");
    require(signal != "tau" || !is_current_unit(unit), "--units: found '", key, "=", unit,
            "', expected tau=", unit, ": currents of all joints.");
    if (!is_unit_of_other_joint_type(choice, unit, joint)) continue;
    throw InvalidInput(text("--units: found '", key, "=", unit, "', but joint ", joint,
                            choice.joints[joint - 1].prismatic ? " slides, expected a unit of lengths." : " turns, expected a unit of angles."));
  }
}

}  // namespace veridyn::recordings
