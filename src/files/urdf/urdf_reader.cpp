#include "veridyn/files/urdf.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <sstream>

#include "files/simulators/simulator_frames.hpp"
#include "files/words.hpp"
#include "math/numbers.hpp"
#include "model/suggestion.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

// to_urdf() writes this where URDF requires a number and the model has none.
constexpr double kUnlimited = 1e9;

// The rotation Rz(yaw) Ry(pitch) Rx(roll), computed through a quaternion with the rounding of urdfdom.
Eigen::Matrix3d rotation(const std::vector<double>& rpy) {
  if (rpy.empty()) return Eigen::Matrix3d::Identity();
  const double phi = rpy[0] / 2.0, the = rpy[1] / 2.0, psi = rpy[2] / 2.0;
  const double x = std::sin(phi) * std::cos(the) * std::cos(psi) - std::cos(phi) * std::sin(the) * std::sin(psi);
  const double y = std::cos(phi) * std::sin(the) * std::cos(psi) + std::sin(phi) * std::cos(the) * std::sin(psi);
  const double z = std::cos(phi) * std::cos(the) * std::sin(psi) - std::sin(phi) * std::sin(the) * std::cos(psi);
  const double w = std::cos(phi) * std::cos(the) * std::cos(psi) + std::sin(phi) * std::sin(the) * std::sin(psi);
  const double s = std::sqrt(x * x + y * y + z * z + w * w);
  const Eigen::Matrix3d R = Eigen::Quaterniond(w / s, x / s, y / s, z / s).toRotationMatrix();
  return (R.array().abs() < std::numeric_limits<double>::epsilon()).select(0.0, R);  // right angles are exact
}

class UrdfReader {
 public:
  explicit UrdfReader(const std::string& path) : xml_(path, "robot", "a URDF file") {}

  Model model() {
    const pugi::xml_node robot = xml_.root();
    reject_xacro(robot);
    model_.name = robot.attribute("name").value();
    if (model_.name.empty()) xml_.fail(robot, "a robot without a name", "<robot name=\"...\">");
    model_.source = xml_.path();
    model_.values = RobotValues::kPrior;
    for (const pugi::xml_node e : robot.children("link")) read_link(e);
    for (const pugi::xml_node e : robot.children("joint")) read_joint(e);
    const std::string root = root_link();
    for (std::size_t j = 0; j < moving_.size(); ++j) follow(j);
    variables_ = joint_variables(xml_, moving_, model_.coordinates);
    if (root != "world") add_link(root);
    for (const pugi::xml_node e : robot.children("link")) {
      if (above_.count(name_of(e)) > 0) add_link(name_of(e));
    }
    add_bodies_without_values();
    return Model(std::move(model_));
  }

 private:
  struct Joint {
    pugi::xml_node node;
    std::string parent;
    JointPlacement placement;
    int moving = -1;  // index in moving_; -1: fixed
  };

  static std::string name_of(pugi::xml_node e) { return e.attribute("name").value(); }
  static std::string element_and_name(pugi::xml_node e) { return std::string(e.name()) + " '" + name_of(e) + "'"; }

  void reject_xacro(pugi::xml_node e) const {
    const auto refuse = [&](const std::string& words) {
      xml_.fail(e, "xacro that was not expanded, '" + words + "'",
                "a URDF: `xacro " + xml_.path() + " > arm.urdf` writes it (`ros2 run xacro xacro` in ROS 2)");
    };
    if (starts_with(e.name(), "xacro:")) refuse(text("<", e.name(), ">"));
    for (const pugi::xml_attribute a : e.attributes()) {
      const bool described = std::strcmp(e.name(), "plugin") != 0;
      if (described && (std::strstr(a.value(), "${") != nullptr || std::strstr(a.value(), "$(") != nullptr)) refuse(a.value());
    }
    for (const pugi::xml_node child : e.children()) {
      if (child.type() == pugi::node_element) reject_xacro(child);
    }
  }

  // The finite numbers of an attribute; empty if it does not exist. @param at  element whose position a
  // message reports.
  std::vector<double> numbers(pugi::xml_node at, const std::string& whose, pugi::xml_node of, const char* name, std::size_t count) const {
    std::vector<double> out;
    if (!of.attribute(name)) return out;
    const std::string words = of.attribute(name).value();
    std::istringstream in(words);
    const std::string found = text(whose, " with ", of.name(), " ", name, "=\"", words, "\"");
    for (std::string word; in >> word;) {
      const std::optional<double> value = number_in(word);
      if (!value || !std::isfinite(*value)) {
        const bool comma = word.find(',') != std::string::npos;
        xml_.fail(at, found, text(count, count == 1 ? " finite number" : " finite numbers with spaces between", comma ? " and a point in them, not a comma" : ""));
      }
      out.push_back(*value);
    }
    if (out.size() != count) xml_.fail(at, found, text(count, count == 1 ? " number" : " numbers"));
    return out;
  }

  double number(pugi::xml_node e, pugi::xml_node of, const char* name, double otherwise) const {
    const std::vector<double> found = numbers(e, element_and_name(e), of, name, 1);
    return found.empty() ? otherwise : found[0];
  }

  // Registers a joint or link, which must have a name that occurs once in the file.
  void register_name(pugi::xml_node e, std::map<std::string, pugi::xml_node>& known) const {
    const std::string tag = e.name(), name = name_of(e);
    if (name.empty()) xml_.fail(e, "a " + tag + " without a name", "<" + tag + " name=\"...\">");
    const auto [there, fresh] = known.emplace(name, e);
    if (!fresh) xml_.fail(e, text("the second ", tag, " '", name, "', after line ", xml_.line(there->second)), "another name for one of them");
  }

  Eigen::Isometry3d pose(pugi::xml_node at, const std::string& whose, pugi::xml_node origin) const {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    const std::vector<double> p = numbers(at, whose, origin, "xyz", 3);
    if (!p.empty()) T.translation() = Eigen::Vector3d(p[0], p[1], p[2]);
    T.linear() = rotation(numbers(at, whose, origin, "rpy", 3));
    return T;
  }

  void read_link(pugi::xml_node e) {
    register_name(e, links_);
    const pugi::xml_node inertial = e.child("inertial"), inertia = inertial.child("inertia");
    const std::string whose = element_and_name(e);
    if (!inertial) return;
    const Eigen::Isometry3d T = pose(inertial, whose, inertial.child("origin"));
    const std::vector<double> mass = numbers(inertial, whose, inertial.child("mass"), "value", 1);
    if (mass.empty()) xml_.fail(inertial, whose + " with an inertial without a mass", "<mass value=\"KG\"/>");
    if (mass[0] < 0.0) xml_.fail(inertial, text(whose, " with a mass of ", mass[0], " kg"), "one that is not negative");
    std::map<std::string, double> i;
    for (const char* key : {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"}) {
      const std::vector<double> one = numbers(inertial, whose, inertia, key, 1);
      if (one.empty())
        xml_.fail(inertial, whose + " with an inertia without " + key, "<inertia ixx=\"\" ixy=\"\" ixz=\"\" iyy=\"\" iyz=\"\" izz=\"\"/> [kg m^2]");
      i[key] = one[0];
    }
    const Eigen::Matrix3d R = T.linear();
    Eigen::Matrix3d I;
    I << i["ixx"], i["ixy"], i["ixz"], i["ixy"], i["iyy"], i["iyz"], i["ixz"], i["iyz"], i["izz"];
    I = (R * I * R.transpose()).eval();
    Eigen::Matrix<double, 6, 1> entries;
    entries << I(0, 0), I(0, 1), I(1, 1), I(0, 2), I(1, 2), I(2, 2);
    Body body;
    body.phi = inertial_parameters(mass[0], T.translation(), entries);
    if (!body.phi->allFinite()) xml_.fail(inertial, whose + " with an inertial that is not finite", "finite numbers");
    bodies_[name_of(e)] = body;
  }

  std::string linked_frame_name(pugi::xml_node e, const char* end) const {
    const std::string name = e.child(end).attribute("link").value();
    if (name.empty()) xml_.fail(e, element_and_name(e) + " without its " + end, text("<", end, " link=\"...\"/>"));
    if (links_.count(name) == 0) {
      std::vector<std::string> known;
      for (const auto& [link, at] : links_) known.push_back(link);
      xml_.fail(e, text(element_and_name(e), " with the ", end, " '", name, "', which is no link"), "the name of a link" + did_you_mean(name, known));
    }
    return name;
  }

  void read_joint(pugi::xml_node e) {
    register_name(e, joints_);
    const std::string whose = element_and_name(e);
    const std::string type = e.attribute("type").value();
    if (type == "floating" || type == "planar")
      xml_.fail(e, whose + " with a " + type + " type", "revolute, continuous, prismatic or fixed; type=\"fixed\" where the base stands still");
    const bool ranged = type == "revolute" || type == "prismatic";
    if (!ranged && type != "continuous" && type != "fixed")
      xml_.fail(e, whose + " with the type '" + type + "'", "revolute, continuous, prismatic or fixed");
    Joint joint{e, linked_frame_name(e, "parent"), {}};
    const std::string child = linked_frame_name(e, "child");
    if (const auto there = above_.find(child); there != above_.end())
      xml_.fail(e, text(whose, " with the child '", child, "', which joint '", name_of(there->second.node), "' carries (line ", xml_.line(there->second.node), ")"),
                "one joint above each link");
    joint.placement.origin = from_eigen(pose(e, whose, e.child("origin")));
    const std::vector<double> axis = numbers(e, whose, e.child("axis"), "xyz", 3);
    if (type != "fixed") {
      const Vec3d u = axis.empty() ? Vec3d{1, 0, 0} : Vec3d{axis[0], axis[1], axis[2]};
      const double length = std::sqrt(dot(u, u));
      if (!(length > 0.0) || !std::isfinite(length)) xml_.fail(e, whose + " with no direction of its axis", "one, as <axis xyz=\"0 0 1\"/>");
      joint.placement.axis = {u.x / length, u.y / length, u.z / length};
    }
    const Limits limits = limits_of(e, ranged, type);
    for (const char* key : {"damping", "friction"}) number(e, e.child("dynamics"), key, 0.0);
    for (const char* key : {"multiplier", "offset"}) number(e, e.child("mimic"), key, 0.0);
    if (type != "fixed") {
      joint.moving = static_cast<int>(moving_.size());
      moving_.push_back({e, name_of(e), type != "prismatic", false, {}, 0.0, limits});
    }
    above_.emplace(child, joint);
  }

  Limits limits_of(pugi::xml_node e, bool ranged, const std::string& type) const {
    Limits out{-kInfinity, kInfinity, kInfinity, kInfinity, kInfinity};
    const pugi::xml_node limit = e.child("limit");
    const std::string expected = "<limit lower=\"\" upper=\"\" velocity=\"\" effort=\"\"/>, 0 for a velocity or an effort that is not known";
    if (ranged && !limit) xml_.fail(e, element_and_name(e) + " of type " + type + " without limits", expected);
    if (!limit) return out;
    const double lower = number(e, limit, "lower", 0.0), upper = number(e, limit, "upper", 0.0);
    for (const char* key : {"velocity", "effort"}) {
      if (!limit.attribute(key)) xml_.fail(e, element_and_name(e) + " with a limit without " + key, expected);
    }
    const double velocity = number(e, limit, "velocity", 0.0), effort = number(e, limit, "effort", 0.0);
    const bool given = ranged && (lower != 0.0 || upper != 0.0) && !e.child("mimic");
    if (given && !(lower < upper)) xml_.fail(e, text(element_and_name(e), " with limits [", lower, ", ", upper, "]"), "lower < upper");
    if (given && lower > -kUnlimited) out.lower = lower;
    if (given && upper < kUnlimited) out.upper = upper;
    if (velocity > 0.0 && velocity < kUnlimited) out.velocity = velocity;
    if (effort > 0.0 && effort < kUnlimited) out.effort = effort;
    return out;
  }

  // The root: the only link without a joint above it, from which joints lead to all others.
  std::string root_link() const {
    if (links_.empty()) xml_.fail(xml_.root(), "no links", "<link name=\"...\">");
    std::vector<std::string> roots;
    for (const pugi::xml_node e : xml_.root().children("link"))
      if (above_.count(name_of(e)) == 0) roots.push_back(name_of(e));
    if (roots.empty()) {
      const pugi::xml_node e = xml_.root().child("joint");
      xml_.fail(e, "a joint above every link ('" + name_of(e) + "' among them)", "a tree: one link without a joint above it");
    }
    if (roots.size() > 1) {
      xml_.fail(links_.at(roots[1]), text(roots.size(), " links without a joint above them: ", listed(roots)),
                "one: a joint of type fixed carries link '" + roots[1] + "', or the link is deleted");
    }
    for (const auto& [child, joint] : above_) {
      std::string at = child;
      for (std::size_t k = 0; above_.count(at) > 0 && k <= above_.size(); ++k) at = above_.at(at).parent;
      if (above_.count(at) > 0) xml_.fail(joint.node, element_and_name(joint.node) + " with a link below itself", "a tree of links");
    }
    return roots[0];
  }

  // Makes a joint mimic another one: variable = multiplier * variable of the leader + offset; a fixed leader
  // stays at zero.
  void follow(std::size_t j) {
    const pugi::xml_node mimic = moving_[j].node.child("mimic");
    if (!mimic) return;
    const std::string leader = mimic.attribute("joint").value();
    if (joints_.count(leader) == 0) xml_.fail(moving_[j].node, element_and_name(moving_[j].node) + " with mimic of the unknown joint '" + leader + "'", "a joint");
    moving_[j].follows = true;
    moving_[j].constant = number(moving_[j].node, mimic, "offset", 0.0);
    for (std::size_t other = 0; other < moving_.size(); ++other) {
      if (moving_[other].name == leader) moving_[j].shares = {{static_cast<int>(other), number(moving_[j].node, mimic, "multiplier", 1.0)}};
    }
  }

  // Adds a link after its ancestors.
  void add_link(const std::string& name) {
    if (frames_.count(name) > 0) return;
    Frame frame;
    frame.name = name;
    if (const auto above = above_.find(name); above != above_.end()) {
      const Joint& joint = above->second;
      if (above_.count(joint.parent) > 0) add_link(joint.parent);
      if (const auto parent = frames_.find(joint.parent); parent != frames_.end()) frame.parent = parent->second;
      if (joint.moving >= 0) {
        frame.type = moving_[joint.moving].turns ? JointType::kRevolute : JointType::kPrismatic;
        frame.variable = variables_[joint.moving];
        for (const char* attribute : {"damping", "friction"}) add_friction(joint, attribute);
      }
      place(frame, joint.placement);
    }
    if (const auto body = bodies_.find(name); body != bodies_.end()) frame.body = body->second;
    frames_[name] = FrameIndex{static_cast<int>(model_.frames.size())};
    model_.frames.push_back(std::move(frame));
  }

  void add_friction(const Joint& joint, const char* attribute) {
    const double value = number(joint.node, joint.node.child("dynamics"), attribute, 0.0);
    if (value < 0.0) xml_.fail(joint.node, text(element_and_name(joint.node), " with a ", attribute, " of ", value), "one that is not negative");
    add_effect(model_, xml_.path(), attribute, {variables_[joint.moving].coefficients, 0.0}, value);
  }

  // A file without any inertial describes the kinematics alone: every link that a joint moves then gets a
  // body without values.
  void add_bodies_without_values() {
    for (const Frame& frame : model_.frames) {
      if (frame.body) return;
    }
    for (Frame& frame : model_.frames) {
      if (frame.type != JointType::kFixed) frame.body = Body{};
    }
  }

  XmlFile xml_;
  ModelDescription model_;
  std::map<std::string, pugi::xml_node> links_, joints_;
  std::map<std::string, Body> bodies_;       // bodies by link
  std::map<std::string, Joint> above_;       // the joint above each link
  std::map<std::string, FrameIndex> frames_;  // frames by link
  std::vector<FileJoint> moving_;
  std::vector<Axis> variables_;
};

}  // namespace

Model read_urdf(const std::string& path) {
  return UrdfReader(path).model();
}

}  // namespace veridyn
