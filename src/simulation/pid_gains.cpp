#include "files/yaml/yaml_node.hpp"
#include "files/input_file.hpp"
#include "simulation/plant/plant_forces.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/math/require.hpp"
#include "kinematics/motion_limits.hpp"
#include "veridyn/simulation/control_loop.hpp"

namespace veridyn {
namespace {

constexpr double kIntegralShare = 0.1;  // integral rate as a share of the bandwidth

// The inertia of each joint with the others held, rotors included, at the middle of the range.
VectorXd middle_inertia(const Model& arm) {
  require(arm.inertial_values().has_value(), "gains: '", arm.name(),
          "' has no values; expected a robot with mass, com and inertia of every body.");
  const MotionLimits limits = motion_limits(arm);
  const VectorXd middle = 0.5 * (limits.lower + limits.upper);
  return mass_matrix(arm, middle).diagonal() + PlantForces(arm).inertia().diagonal();
}

// @param source  state of reading; it must outlive the returned node.
YamlNode gains_file(const std::string& path, const std::string& expected, YamlSource& source) {
  const std::string content = content_of_file(path, "gains (YAML with " + expected + ")");
  source.file = path;
  source.expected = expected;
  return YamlNode::parse(content, source);
}

VectorXd gains_in(const YamlNode& node, int joints) {
  const std::vector<double> numbers =
      node.numbers(static_cast<size_t>(joints), "one gain per joint");
  return Eigen::Map<const VectorXd>(numbers.data(), joints);
}

}  // namespace

VectorXd critical_damping(const Model& arm, const VectorRef& p) {
  return 2.0 * (p.array() * middle_inertia(arm).array()).max(0.0).sqrt();
}

PidGains sensible_gains(const Model& arm, double frequency) {
  const double omega = 2.0 * M_PI * frequency;
  const VectorXd p = omega * omega * middle_inertia(arm);
  return {p, kIntegralShare * omega * p, critical_damping(arm, p)};
}

PidGains read_gains(const std::string& path, const Model& arm) {
  YamlSource source;
  const YamlNode root = gains_file(path, "lists p, i and d", source);
  root.allow_keys({"p", "i", "d"});
  PidGains gains{gains_in(root.at("p"), arm.joints()), VectorXd::Zero(arm.joints()), {}};
  if (const auto i = root.find("i")) gains.i = gains_in(*i, arm.joints());
  const auto d = root.find("d");
  gains.d = d ? gains_in(*d, arm.joints()) : critical_damping(arm, gains.p);
  return gains;
}

JointGains read_joint_gains(const std::string& path, const Model& arm) {
  YamlSource source;
  const YamlNode root = gains_file(path, "lists p and d", source);
  root.allow_keys({"p", "d"});
  JointGains gains{gains_in(root.at("p"), arm.joints()), {}};
  const auto d = root.find("d");
  gains.d = d ? gains_in(*d, arm.joints()) : VectorXd(2.0 * gains.p.cwiseMax(0.0).cwiseSqrt());
  return gains;
}

ImpedanceGains read_tip_gains(const std::string& path) {
  YamlSource source;
  const YamlNode root = gains_file(path, "lists mass, damping and stiffness", source);
  root.allow_keys({"mass", "damping", "stiffness"});
  ImpedanceGains gains;
  const auto three = [&](const char* key, auto& all) {
    const VectorXd numbers = gains_in(root.at(key), 3);
    all << numbers, numbers;
  };
  three("mass", gains.mass);
  three("damping", gains.damping);
  three("stiffness", gains.stiffness);
  return gains;
}

}  // namespace veridyn
