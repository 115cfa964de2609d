#include "recordings/signals/units.hpp"

#include <cmath>
#include <iterator>

#include "veridyn/math/require.hpp"

namespace veridyn::recordings {
namespace {

const double kPi = std::acos(-1.0);

struct Unit {
  const char* signal;
  const char* unit;
  double factor;
};

const Unit* units_begin() {
  static const Unit kUnits[] = {
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
      {"tau", "kNm", 1e3},        {"tau", "A", 1.0},
      {"tau", "mA", 1e-3},        {"i", "A", 1.0},
      {"i", "mA", 1e-3},          {"t", "s", 1.0},
      {"t", "ms", 1e-3},          {"t", "us", 1e-6},
      {"t", "ns", 1e-9},          {"t", "min", 60.0},
      {nullptr, nullptr, 0.0}};
  return kUnits;
}

bool turns_only(std::string unit) {
  if (unit.rfind('-', 0) == 0) unit.erase(0, 1);
  return unit.rfind("deg", 0) == 0 || unit.rfind("mrad", 0) == 0 || unit == "rev" ||
         unit == "rpm" || unit.rfind("rad", 0) == 0;
}

bool slides_only(std::string unit) {
  if (unit.rfind('-', 0) == 0) unit.erase(0, 1);
  return unit.rfind("mm", 0) == 0;
}

// True for degrees where the joint is known to slide, and millimetres where it is known to turn.
bool of_other_joints(const SignalChoice& choice, const std::string& unit, int joint) {
  if (joint < 1 || static_cast<std::size_t>(joint) > choice.joints.size()) return false;
  return choice.joints[joint - 1].prismatic ? turns_only(unit) : slides_only(unit);
}

}  // namespace

std::optional<double> unit_factor(const std::string& signal, const std::string& unit) {
  if (unit.rfind('-', 0) == 0) {
    const std::optional<double> factor = unit_factor(signal, unit.substr(1));
    return factor && signal != "t" ? std::optional<double>(-*factor) : std::nullopt;
  }
  for (const Unit* u = units_begin(); u->signal != nullptr; ++u) {
    if (signal == u->signal && unit == u->unit) return u->factor;
  }
  return std::nullopt;
}

bool is_current_unit(const std::string& unit) {
  return unit == "A" || unit == "mA" || unit == "-A" || unit == "-mA";
}

std::string unit_of(const SignalChoice& choice, const std::string& signal, int joint) {
  const auto own = choice.units.find(text(signal, joint));
  if (own != choice.units.end()) return own->second;
  const auto all = choice.units.find(signal);
  return all == choice.units.end() ? std::string() : all->second;
}

double factor_for(const SignalChoice& choice, const std::string& signal, int joint) {
  const std::string unit = unit_of(choice, signal, joint);
  if (unit.empty()) return 1.0;
  if (of_other_joints(choice, unit, joint)) return 1.0;
  return unit_factor(signal, unit).value_or(1.0);
}

void require_known_units(const SignalChoice& choice) {
  for (const auto& [key, unit] : choice.units) {
    const std::size_t digits = key.find_last_not_of("0123456789") + 1;
    const std::string signal = key.substr(0, digits);
    std::string known;
    for (const Unit* u = units_begin(); u->signal != nullptr; ++u) {
      if (signal == u->signal) known += (known.empty() ? "" : ", ") + std::string(u->unit);
    }
    require(!known.empty(), "--units: found '", key, "', expected t, q, dq, ddq, tau or i.");
    require(unit_factor(signal, unit).has_value(), "--units: found '", key, "=", unit,
            "', expected one of: ", known, " (with - in front for the other sign).");
  }
}

void require_joints_of(const SignalChoice& choice, int joints, const std::string& path) {
  for (const auto& [key, unit] : choice.units) {
    const std::size_t digits = key.find_last_not_of("0123456789") + 1;
    if (digits == key.size()) continue;
    const int joint = key.size() - digits <= 6 ? std::stoi(key.substr(digits)) : 0;
    require(joint >= 1 && joint <= joints, "--units: found '", key, "', but ", path, " has ", joints,
            joints == 1 ? " joint." : " joints.");
    require(key.rfind("tau", 0) != 0 || !is_current_unit(unit), "--units: found '", key, "=", unit,
            "', expected tau=", unit, ": currents of all joints.");
    if (!of_other_joints(choice, unit, joint)) continue;
    throw InvalidInput(text("--units: found '", key, "=", unit, "', but joint ", joint,
                            choice.joints[joint - 1].prismatic ? " slides, expected a unit of lengths." : " turns, expected a unit of angles."));
  }
}

}  // namespace veridyn::recordings
