#include "files/yaml/yaml_body.hpp"

namespace veridyn {
namespace {

const char* const kTenExpected = "ten numbers [m, hx, hy, hz, Lxx, Lxy, Lyy, Lxz, Lyz, Lzz]";

InertialParameters ten_numbers(const YamlNode& node) {
  const std::vector<double> v = node.numbers(kBodyParameters, kTenExpected);
  return Eigen::Map<const InertialParameters>(v.data());
}

double deviation(const YamlNode& node) {
  const double value = node.number_or_infinity();
  if (value < 0.0) node.fail("the negative standard deviation " + node.found(), "0 or more");
  return value;
}

// Reads the inertia about the centre of mass, in the order of inertial_parameters().
Eigen::Matrix<double, 6, 1> read_inertia(const YamlNode& node) {
  const std::vector<std::string> keys{"xx", "xy", "yy", "xz", "yz", "zz"};
  node.allow_keys(keys);
  Eigen::Matrix<double, 6, 1> inertia = Eigen::Matrix<double, 6, 1>::Zero();
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const auto value = node.find(keys[i]);
    if (!value) continue;
    inertia[static_cast<Eigen::Index>(i)] = value->number();
  }
  return inertia;
}

InertialParameters read_mass_com_inertia(const YamlNode& node) {
  const YamlNode mass_node = node.at("mass");
  const double mass = mass_node.number();
  if (mass < 0.0) mass_node.fail("the negative mass " + mass_node.found(), "0 or more");
  Eigen::Vector3d com = Eigen::Vector3d::Zero();
  if (const auto given = node.find("com")) {
    const std::vector<double> c = given->numbers(3, "three numbers [x, y, z]");
    com = {c[0], c[1], c[2]};
  }
  Eigen::Matrix<double, 6, 1> inertia = Eigen::Matrix<double, 6, 1>::Zero();
  if (const auto given = node.find("inertia")) inertia = read_inertia(*given);
  const InertialParameters phi = inertial_parameters(mass, com, inertia);
  if (!phi.allFinite()) node.fail("a body whose inertia about its frame is no finite number", "mass in kg and com in m");
  return phi;
}

std::optional<InertialParameters> read_values(const YamlNode& node) {
  const auto parameters = node.find("parameters");
  for (const char* key : {"mass", "com", "inertia"}) {
    const auto given = node.find(key);
    if (!given) continue;
    if (parameters) given->fail("both parameters and " + std::string(key), "one of them");
    return read_mass_com_inertia(node);
  }
  if (parameters) return ten_numbers(*parameters);
  return std::nullopt;
}

InertialParameters read_deviations(const YamlNode& node) {
  InertialParameters deviations = InertialParameters::Zero();
  if (!node.is_map()) {
    const std::vector<YamlNode> items = node.items(kTenExpected);
    if (items.size() != kBodyParameters) node.fail(node.found(), kTenExpected);
    for (std::size_t i = 0; i < items.size(); ++i)
      deviations[static_cast<Eigen::Index>(i)] = deviation(items[i]);
    return deviations;
  }
  node.allow_keys(inertial_parameter_names());
  for (Eigen::Index i = 0; i < kBodyParameters; ++i) {
    if (const auto value = node.find(inertial_parameter_names()[i])) {
      deviations[i] = deviation(*value);
    }
  }
  return deviations;
}

// The positive number of a key; 0, for no bound, without the key.
double read_bound(const YamlNode& node, const std::string& key) {
  const auto value = node.find(key);
  return value ? value->positive_number() : 0.0;
}

}  // namespace

const std::vector<std::string>& inertial_parameter_names() {
  static const std::vector<std::string> names{"m",   "hx",  "hy",  "hz",  "Lxx",
                                              "Lxy", "Lyy", "Lxz", "Lyz", "Lzz"};
  return names;
}

std::optional<Body> read_body(const YamlNode& node) {
  Body body;
  if (!node.is_map()) {
    if (node.is_list()) node.fail(node.found(), "true or a map of values");
    if (node.flag()) return body;
    return std::nullopt;
  }
  node.allow_keys({"mass", "com", "inertia", "parameters", "std", "prior", "fixed", "box"});
  body.phi = read_values(node);
  if (const auto prior = node.find("prior")) {
    prior->allow_keys({"mass", "com", "inertia", "parameters"});
    body.prior = read_values(*prior);
  }
  if (const auto deviations = node.find("std")) body.std_phi = read_deviations(*deviations);
  if (const auto box = node.find("box")) body.box = read_box(*box);
  if (const auto fixed = node.find("fixed")) {
    body.fixed = fixed->flag();
    if (body.fixed && !body.phi)
      fixed->fail("a fixed body without values", "mass, com and inertia to hold it to");
  }
  return body;
}

ParameterBox read_box(const YamlNode& node) {
  node.allow_keys({"mass_max", "com_reach", "effect_max"});
  return {read_bound(node, "mass_max"), read_bound(node, "com_reach"),
          read_bound(node, "effect_max")};
}

}  // namespace veridyn
