#include "cooperation/scenario/scenario_objects.hpp"

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

ForceLaw read_law(const YamlNode& node, double stiffness) {
  node.allow_keys({"kind", "deadband", "increment", "gain", "proportional", "damping",
                   "feed_forward", "reach", "stiffness"});
  ForceLaw law;
  law.kind =
      read_choice<ForceLaw::Kind>(node.at("kind"), {{"increment", ForceLaw::Kind::kIncrement},
                                               {"proportional", ForceLaw::Kind::kProportional},
                                               {"tuned", ForceLaw::Kind::kProportional}});  // see read_member()
  law.deadband = read_nonnegative_or(node, "deadband", 0.0);
  law.increment = read_nonnegative_or(node, "increment", 0.0);
  law.gain = read_nonnegative_or(node, "gain", 0.0);
  law.proportional = read_nonnegative_or(node, "proportional", 0.0);
  law.damping = read_nonnegative_or(node, "damping", 0.0);
  law.feed_forward = read_nonnegative_or(node, "feed_forward", 0.0);
  law.reach = read_positive_or(node, "reach", law.reach);
  law.stiffness = read_nonnegative_or(node, "stiffness", stiffness);
  return law;
}

ForceSensorOptions read_sensor(const YamlNode& node, const std::vector<std::string>& further = {}) {
  std::vector<std::string> keys = {"rate", "delay", "noise", "step"};
  keys.insert(keys.end(), further.begin(), further.end());
  node.allow_keys(keys);
  ForceSensorOptions sensor;
  sensor.rate = read_positive_or(node, "rate", sensor.rate);
  sensor.delay = read_nonnegative_or(node, "delay", 0.0);
  sensor.noise = read_nonnegative_or(node, "noise", 0.0);
  sensor.step = read_nonnegative_or(node, "step", 0.0);
  const double under_way = sensor.rate * (1.0 + sensor.delay);
  if (!(under_way < ForceSensor::kMostUnderWay))
    node.fail(text(sensor.rate, " Hz with a delay of ", sensor.delay, " s"),
              text("fewer than ", ForceSensor::kMostUnderWay, " samples under way and in a second"));
  return sensor;
}

}  // namespace

ScenarioMember read_member(const YamlNode& node, const Names& arms) {
  node.allow_keys({"name", "kind", "between", "stiffness", "damping", "slack", "sensor", "law"});
  ScenarioMember member;
  member.name = node.at("name").word("the member's name");
  enum class Kind { kSpring, kString, kBar };
  const Kind kind = read_choice<Kind>(
      node.at("kind"), {{"spring", Kind::kSpring}, {"string", Kind::kString}, {"bar", Kind::kBar}});
  const std::vector<YamlNode> ends = node.at("between").items("two arms");
  if (ends.size() != 2) node.at("between").fail(node.at("between").found(), "two arms");
  member.from = arms.index(ends[0]);
  member.to = arms.index(ends[1]);
  if (member.from == member.to) ends[1].fail("the same arm twice", "two arms");
  if (kind == Kind::kBar) {
    member.stiffness = read_positive_or(node, "stiffness", kRigidStiffness);
    member.damping = read_nonnegative_or(node, "damping", kRigidDamping);
  } else {
    member.stiffness = node.at("stiffness").positive_number();
    member.damping = read_nonnegative_or(node, "damping", 0.0);
  }
  member.pulls_only = kind == Kind::kString;
  if (const auto slack = node.find("slack")) member.slack = slack->number();
  if (const auto sensor = node.find("sensor")) member.sensor = read_sensor(*sensor);
  const YamlNode law = node.at("law");
  member.tuned = law.is_map() && law.at("kind").word("a kind of law") == "tuned";
  if (member.tuned) {
    law.allow_keys({"kind"});
  } else {
    member.law = read_law(law, member.stiffness);
  }
  return member;
}

ScenarioWall read_wall(const YamlNode& node, const Names& arms) {
  node.allow_keys({"name", "arm", "point", "normal", "stiffness", "stiffening", "damping", "drag",
                   "sensor"});
  ScenarioWall wall;
  wall.name = node.at("name").word("the wall's name");
  wall.arm = arms.index(node.at("arm"));
  if (const auto point = node.find("point")) wall.point = read_vector3(*point, "m");
  const YamlNode normal = node.at("normal");
  const Eigen::Vector3d n = read_vector3(normal, "1");
  if (!(n.norm() > 1e-9)) normal.fail("a normal of length zero", "a direction");
  wall.normal = n.normalized();
  wall.stiffness = node.at("stiffness").positive_number();
  wall.stiffening = read_nonnegative_or(node, "stiffening", 0.0);
  wall.damping = read_nonnegative_or(node, "damping", 0.0);
  wall.drag = read_nonnegative_or(node, "drag", 0.0);
  if (const auto sensor = node.find("sensor")) {
    wall.sensor = read_sensor(*sensor, {"axes"});
    if (const auto axes = sensor->find("axes"))
      wall.sensor_axes = read_choice<int>(*axes, {{"1", 1}, {"3", 3}});
  }
  return wall;
}

ScenarioBody read_body(const YamlNode& node, const Names& arms) {
  node.allow_keys({"name", "mass", "inertia", "grasps", "impedance", "internal_force"});
  ScenarioBody body;
  body.name = node.at("name").word("the body's name");
  body.mass = node.at("mass").positive_number();
  const YamlNode inertia = node.at("inertia");
  body.inertia = read_vector3(inertia, "kg m^2");
  if (!(body.inertia.minCoeff() > 0.0))
    inertia.fail("an inertia that is not above zero", "three numbers above zero [kg m^2]");
  for (const YamlNode& item : node.at("grasps").items("a list of grasps")) {
    item.allow_keys({"arm", "stiffness", "damping"});
    ScenarioBody::Grasp grasp;
    grasp.arm = arms.index(item.at("arm"));
    for (const ScenarioBody::Grasp& other : body.grasps) {
      if (other.arm == grasp.arm) item.at("arm").fail("the same arm twice", "each arm once");
    }
    grasp.stiffness = item.at("stiffness").positive_number();
    grasp.damping = read_nonnegative_or(item, "damping", 0.0);
    body.grasps.push_back(grasp);
  }
  if (body.grasps.empty()) node.at("grasps").fail("no grasps", "at least one");
  const auto impedance = node.find("impedance");
  if (const auto force = node.find("internal_force")) {
    body.internal_force = force->number();
    if (!impedance || body.grasps.size() < 2) force->fail("a force between hands", "an impedance and two grasps beside it");
  }
  if (!impedance) return body;
  impedance->allow_keys({"mass", "damping", "stiffness", "inertia", "angular_damping",
                         "angular_stiffness"});
  body.wanted_mass = read_positive_or(*impedance, "mass", body.wanted_mass);
  body.impedance_stiffness = impedance->at("stiffness").positive_number();
  body.impedance_damping = read_nonnegative_or(*impedance, "damping", 0.0);
  body.wanted_inertia = read_positive_or(*impedance, "inertia", body.wanted_inertia);
  body.angular_stiffness = read_nonnegative_or(*impedance, "angular_stiffness", 0.0);
  body.angular_damping = read_nonnegative_or(*impedance, "angular_damping", 0.0);
  return body;
}

}  // namespace veridyn
