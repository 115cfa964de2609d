#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

#include "veridyn/files/words.hpp"
#include "veridyn/cooperation/stability.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/model/suggestion.hpp"

namespace veridyn {
namespace {

// Accessors of a parameter; a scenario without members or walls has no force to change.
struct Access {
  StabilityParameter of;
  double (*get)(const Scenario&);
  void (*set)(Scenario&, double);
  bool above_zero;
};

// Getters of the object give the value of its first member, else of the first wall; setters change all of them.
template <typename Change>
void every_member(Scenario& s, const Change& change) {
  for (ScenarioMember& m : s.members) change(m);
}

template <double ForceLaw::*field>
void set_law(Scenario& s, double x) {
  every_member(s, [x](ScenarioMember& m) {
    m.law.*field = x;
    m.tuned = false;
  });
}
template <double ForceLaw::*field>
double get_law(const Scenario& s) {
  return s.members.empty() ? 0.0 : s.members.front().law.*field;
}
template <double ScenarioControl::*field>
double get_control(const Scenario& s) {
  return s.control.*field;
}
template <double ScenarioControl::*field>
void set_control(Scenario& s, double x) {
  s.control.*field = x;
}
// The mean of the three axes.
template <Eigen::Vector3d ScenarioControl::*field>
double get_axes(const Scenario& s) {
  return (s.control.*field).mean();
}
template <Eigen::Vector3d ScenarioControl::*field>
void set_axes(Scenario& s, double x) {
  s.control.*field = Eigen::Vector3d::Constant(x);
}

const ForceSensorOptions& first_sensor(const Scenario& s) {
  static const ForceSensorOptions none;
  return !s.members.empty() ? s.members.front().sensor
         : !s.walls.empty() ? s.walls.front().sensor
                            : none;
}
template <double ForceSensorOptions::*field>
double get_sensor(const Scenario& s) {
  return first_sensor(s).*field;
}
template <double ForceSensorOptions::*field>
void set_sensor(Scenario& s, double x) {
  for (ScenarioMember& m : s.members) m.sensor.*field = x;
  for (ScenarioWall& w : s.walls) w.sensor.*field = x;
}

double get_stiffness(const Scenario& s) {
  return !s.members.empty() ? s.members.front().stiffness
         : !s.walls.empty() ? s.walls.front().stiffness
                            : 0.0;
}
void set_stiffness(Scenario& s, double x) {
  for (ScenarioMember& m : s.members) m.stiffness = m.law.stiffness = x;
  for (ScenarioWall& w : s.walls) w.stiffness = x;
}
double get_damping(const Scenario& s) {
  return !s.members.empty() ? s.members.front().damping
         : !s.walls.empty() ? s.walls.front().damping
                            : 0.0;
}
void set_damping(Scenario& s, double x) {
  for (ScenarioMember& m : s.members) m.damping = x;
  for (ScenarioWall& w : s.walls) w.damping = x;
}

const std::vector<Access>& parameter_accessors() {
  using C = ScenarioControl;
  using L = ForceLaw;
  using S = ForceSensorOptions;
  static const std::vector<Access> all = {
      {{"stiffness", "N/m", "of the object's members and walls", true}, get_stiffness, set_stiffness, true},
      {{"object_damping", "N s/m", "of the object's members and walls"}, get_damping, set_damping, false},
      {{"delay", "s", "of every force sensor"}, get_sensor<&S::delay>, set_sensor<&S::delay>, false},
      {{"sensor_rate", "Hz", "of every force sensor"}, get_sensor<&S::rate>, set_sensor<&S::rate>, true},
      {{"rate", "Hz", "of the control loop"}, get_control<&C::rate>, set_control<&C::rate>, true},
      {{"mass", "kg", "desired inertia of impedances, all axes", true}, get_axes<&C::mass>, set_axes<&C::mass>, true},
      {{"damping", "N s/m", "of impedances, all axes"}, get_axes<&C::damping>, set_axes<&C::damping>, false},
      {{"impedance_stiffness", "N/m", "of impedances, all axes", true}, get_axes<&C::stiffness>, set_axes<&C::stiffness>, true},
      {{"position_frequency", "Hz", "of position loops"}, get_control<&C::position_frequency>, set_control<&C::position_frequency>, true},
      {{"friction", "1", "share of the friction that is compensated"}, get_control<&C::friction>, set_control<&C::friction>, false},
      {{"observer", "Hz", "of the observer of model errors"}, get_control<&C::observer>, set_control<&C::observer>, false},
      {{"velocity_cutoff", "Hz", "of the velocity observer"}, get_control<&C::velocity_cutoff>, set_control<&C::velocity_cutoff>, true},
      {{"force_cutoff", "Hz", "of the low-pass of force readings; 0: none"}, get_control<&C::force_cutoff>, set_control<&C::force_cutoff>, false},
      {{"motor_lag", "s", "between torques asked and made"}, get_control<&C::motor_lag>, set_control<&C::motor_lag>, false},
      {{"torque_delay", "cycles", "of torques beyond the cycle"},
       [](const Scenario& s) { return static_cast<double>(s.control.torque_delay); },
       [](Scenario& s, double x) {
         require(x <= kLongestTorqueDelay, "parameter torque_delay: found ", x, " cycles, expected at most ", kLongestTorqueDelay, ".");
         s.control.torque_delay = static_cast<int>(std::lround(x));
       }, false},
      {{"gain", "m/(N s)", "K_f of force laws", true}, get_law<&L::gain>, set_law<&L::gain>, false},
      {{"proportional", "m/N", "of force laws"}, get_law<&L::proportional>, set_law<&L::proportional>, false},
      {{"law_damping", "s", "of force laws"}, get_law<&L::damping>, set_law<&L::damping>, false},
      {{"deadband", "N", "of force laws"}, get_law<&L::deadband>, set_law<&L::deadband>, false},
      {{"increment", "m", "of force laws, per sample"}, get_law<&L::increment>, set_law<&L::increment>, false}};
  return all;
}

// Accessors of a parameter by name; throws InvalidInput with the known names.
const Access& accessor(const std::string& name) {
  std::vector<std::string> names;
  for (const Access& a : parameter_accessors()) {
    if (a.of.name == name) return a;
    names.push_back(a.of.name);
  }
  throw InvalidInput(text("found the parameter '", name, "'", did_you_mean(name, names),
                          ", expected one of: ", listed(names), "."));
}

// Throws InvalidInput, with the whole range as given, if the word is no finite number.
double read_number(const std::string& word, const std::string& whole) {
  const std::optional<double> x = number_in(word);
  require(x && std::isfinite(*x), "found '", whole,
          "', expected NAME=FROM:TO:COUNT with two numbers and a count.");
  return *x;
}

}  // namespace

const std::vector<StabilityParameter>& stability_parameters() {
  static const std::vector<StabilityParameter> all = [] {
    std::vector<StabilityParameter> out;
    for (const Access& a : parameter_accessors()) out.push_back(a.of);
    return out;
  }();
  return all;
}

Scenario with_parameter(const Scenario& scenario, const std::string& name, double value) {
  const Access& a = accessor(name);
  require(std::isfinite(value) && (a.above_zero ? value > 0.0 : value >= 0.0), "parameter ", name,
          ": found ", value, ", expected a number ", a.above_zero ? "above zero." : "not below zero.");
  Scenario out = scenario;
  a.set(out, value);
  tune_force_laws(out);
  return out;
}

double parameter(const Scenario& scenario, const std::string& name) {
  return accessor(name).get(scenario);
}

std::vector<double> ParameterRange::values() const {
  const bool by_ratio = accessor(name).of.logarithmic && from > 0.0;
  std::vector<double> out;
  for (int k = 0; k < count; ++k) {
    const double share = count > 1 ? static_cast<double>(k) / (count - 1) : 0.0;
    out.push_back(by_ratio ? from * std::pow(to / from, share) : from + share * (to - from));
  }
  return out;
}

ParameterRange parse_range(const std::string& whole) {
  const auto equals = whole.find('=');
  const auto first = whole.find(':', equals == std::string::npos ? 0 : equals);
  const auto second = first == std::string::npos ? first : whole.find(':', first + 1);
  require(equals != std::string::npos && second != std::string::npos, "found '", whole,
          "', expected NAME=FROM:TO:COUNT.");
  ParameterRange range;
  range.name = whole.substr(0, equals);
  range.from = read_number(whole.substr(equals + 1, first - equals - 1), whole);
  range.to = read_number(whole.substr(first + 1, second - first - 1), whole);
  const double count = read_number(whole.substr(second + 1), whole);
  require(count >= 2.0 && count <= 1000.0 && count == std::floor(count), "found ", count, " in '",
          whole, "', expected a count from 2 to 1000.");
  require(range.from < range.to, "found '", whole, "', expected FROM below TO.");
  range.count = static_cast<int>(count);
  const Access& a = accessor(range.name);
  require(a.above_zero ? range.from > 0.0 : range.from >= 0.0, "found '", whole,
          "', expected values ", a.above_zero ? "above zero." : "not below zero.");
  return range;
}

}  // namespace veridyn
