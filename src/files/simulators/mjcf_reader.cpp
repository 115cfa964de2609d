#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>

#include "math/numbers.hpp"
#include "files/simulators/mjcf_elements.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/simulator_files.hpp"

namespace veridyn {
namespace {

class MjcfReader : private MjcfElements {
 public:
  explicit MjcfReader(const std::string& path) : MjcfElements(path) { read_option(); }

  Model model() {
    model_.name = root().attribute("model") ? root().attribute("model").value() : "MuJoCo Model";
    model_.source = xml_.path();
    model_.values = RobotValues::kPrior;
    for (const pugi::xml_node world : root().children("worldbody")) {
      for (const char* kind : {"joint", "freejoint", "inertial"}) {
        if (const pugi::xml_node node = world.child(kind))
          xml_.fail(node, text("<", kind, "> in the worldbody"), "it inside of a body");
      }
      children(world, std::nullopt, Eigen::Isometry3d::Identity(), false);
    }
    read_couplings();
    read_actuators();
    variables_ = joint_variables(xml_, joints_, model_.coordinates);
    finish_frames();
    for (std::size_t j = 0; j < joints_.size(); ++j) read_joint_effects(j);
    read_tendons();
    for (const auto& [joint, bias] : biases_) add_constant_force(joint, bias);
    return Model(std::move(model_));
  }

 private:
  void read_option() {
    pugi::xml_node at = root().child("option");
    if (const pugi::xml_attribute given = setting("option", "gravity", &at))
      model_.gravity = as_vector(xml_.numbers(at, "gravity", given.value(), 3, 3));
    for (const char* name : {"density", "viscosity"}) {
      const pugi::xml_attribute given = setting("option", name, &at);
      if (given && xml_.number(at, name, given.value()) != 0.0)
        xml_.fail(at, text("a medium (", name, " ", given.value(), ")"), "none: its drag is not known here");
    }
    for (const pugi::xml_node option : root().children("option")) {
      for (const char* name : {"gravity", "passive", "frictionloss", "equality", "limit"}) {
        if (std::strcmp(option.child("flag").attribute(name).value(), "disable") == 0)
          xml_.fail(option.child("flag"), text("the flag ", name, " disabled"), "it enabled");
      }
    }
  }

  std::string unique_name(const std::string& wanted) {
    std::string name = wanted;
    for (int k = 2; !names_.insert(name).second; ++k) name = wanted + "_" + std::to_string(k);
    return name;
  }

  void add_frame(Frame frame, int joint) {
    model_.frames.push_back(std::move(frame));
    joint_of_frame_.push_back(joint);
  }

  // Reads bodies and sites below a body. `T` is the pose of the body's own axes in the frame `parent`.
  void children(pugi::xml_node above, std::optional<FrameIndex> parent, const Eigen::Isometry3d& T, bool moves) {
    for (const pugi::xml_node node : above.children()) {
      const std::string kind = node.name();
      if (kind == "body") read_body(node, parent, T, moves);
      if (kind == "frame") {
        for (const char* inner : {"joint", "freejoint", "inertial"}) {
          if (const pugi::xml_node in = node.child(inner)) xml_.fail(in, text("<", inner, "> in a <frame>"), "it in its body");
        }
        children(node, parent, T * pose(node), moves);
      }
      if (kind == "site" && *node.attribute("name").value() != 0 && !is_body_site(node)) read_site(node, parent, T * pose(node));
      if (kind == "composite" || kind == "flexcomp" || kind == "replicate")
        xml_.fail(node, "<" + kind + ">", "bodies, joints and geoms one by one");
    }
  }

  // True for a site with the name of its body: it is the pose of the body's frame, as in exported files.
  static bool is_body_site(pugi::xml_node node) {
    return std::strcmp(node.parent().name(), "body") == 0 &&
           std::strcmp(node.attribute("name").value(), node.parent().attribute("name").value()) == 0;
  }

  void read_site(pugi::xml_node node, std::optional<FrameIndex> parent, const Eigen::Isometry3d& T) {
    Frame frame;
    frame.name = unique_name(node.attribute("name").value());
    frame.parent = parent;
    place(frame, {from_eigen(T), {0, 0, 1}, {0, 0, 0}});
    add_frame(std::move(frame), -1);
  }

  void read_body(pugi::xml_node node, std::optional<FrameIndex> parent, const Eigen::Isometry3d& before, bool moves) {
    if (node.child("freejoint")) xml_.fail(node.child("freejoint"), "a body that moves freely", "arms on a fixed base");
    if (const pugi::xml_attribute a = node.attribute("gravcomp"); a && xml_.number(node, "gravcomp", a.value()) != 0.0)
      xml_.fail(node, "gravity compensation of a body (gravcomp)", "none: motors carry the weight");
    const std::string own = node.attribute("name").value();
    const std::string name = unique_name(own.empty() ? "body_" + std::to_string(model_.frames.size() + 1) : own);
    Eigen::Isometry3d T_body_frame = Eigen::Isometry3d::Identity();
    for (const pugi::xml_node s : node.children("site")) {
      if (!own.empty() && is_body_site(s)) T_body_frame = pose(s);
    }
    std::vector<pugi::xml_node> joints;
    for (const pugi::xml_node j : node.children("joint")) joints.push_back(j);
    Eigen::Isometry3d T = before * pose(node);
    for (std::size_t k = 0; k < joints.size(); ++k) {
      const bool last = k + 1 == joints.size();
      Frame frame;
      frame.parent = parent;
      const int index = joint(joints[k], name, frame, T);
      frame.name = last ? name : unique_name(name + "__" + joints_[index].name);
      if (last) frame.B = frame.B * from_eigen(T_body_frame);
      parent = FrameIndex{static_cast<int>(model_.frames.size())};
      add_frame(std::move(frame), index);
      T = Eigen::Isometry3d::Identity();
    }
    if (joints.empty()) {
      Frame frame;
      frame.name = name;
      frame.parent = parent;
      place(frame, {from_eigen(T * T_body_frame), {0, 0, 1}, {0, 0, 0}});
      parent = FrameIndex{static_cast<int>(model_.frames.size())};
      add_frame(std::move(frame), -1);
    }
    moves = moves || !joints.empty();
    const Eigen::Isometry3d T_frame_body = T_body_frame.inverse(Eigen::Isometry);
    model_.frames[parent->value].body = inertia(node, T_frame_body, moves);
    children(node, parent, T_frame_body, moves);
  }

  // Reads a joint of a body whose axes are at T in the zero position; sets the frame's type and placement.
  int joint(pugi::xml_node node, const std::string& body, Frame& frame, const Eigen::Isometry3d& T) {
    FileJoint out;
    out.node = node;
    const std::string type = given(node, "type") ? given(node, "type").value() : "hinge";
    if (type != "hinge" && type != "slide") xml_.fail(node, "a joint of type '" + type + "'", "hinge or slide");
    out.turns = type == "hinge";
    out.name = node.attribute("name") ? node.attribute("name").value() : body + "_joint";
    for (const FileJoint& other : joints_) {
      if (other.name == out.name) xml_.fail(node, "a second joint '" + out.name + "'", "names that are unique");
    }
    const double unit = out.turns ? angle() : 1.0;
    out.limits = {-kInfinity, kInfinity, kInfinity, kInfinity, kInfinity};
    if (const auto range = numbers(node, "range", 2, 2); !range.empty() && limited(node, "limited")) {
      if (!(range[0] < range[1])) xml_.fail(node, text("the range ", range[0], " ", range[1]), "lower < upper");
      out.limits.lower = unit * range[0];
      out.limits.upper = unit * range[1];
    }
    if (const auto force = numbers(node, "actuatorfrcrange", 2, 2); !force.empty() && limited(node, "actuatorfrclimited"))
      out.limits.effort = std::max(std::abs(force[0]), std::abs(force[1]));
    const auto p = numbers(node, "pos", 3, 3);
    const Eigen::Vector3d at = p.empty() ? Eigen::Vector3d(0, 0, 0) : as_vector(p);
    const auto axis = numbers(node, "axis", 3, 3);
    frame.type = out.turns ? JointType::kRevolute : JointType::kPrismatic;
    place(frame, {from_eigen(Eigen::Isometry3d(T * Eigen::Translation3d(at))),
                  unit_axis(xml_, node, axis.empty() ? Eigen::Vector3d(0, 0, 1) : as_vector(axis)),
                  {-at.x(), -at.y(), -at.z()}});
    frame.variable.offset = -unit * number(node, "ref", 0.0);
    joints_.push_back(out);
    return static_cast<int>(joints_.size()) - 1;
  }

  int find_joint(pugi::xml_node at, const char* attribute) const {
    const std::string name = at.attribute(attribute).value();
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      if (joints_[j].name == name) return static_cast<int>(j);
    }
    xml_.fail(at, text(attribute, " '", name, "'"), "the name of a hinge or slide");
  }

  // [rad], [m] joint position in the pose of the file.
  double reference_position(int joint) const {
    const FileJoint& j = joints_[joint];
    return (j.turns ? angle() : 1.0) * number(j.node, "ref", 0.0);
  }

  double spring_reference(int joint) const {
    const FileJoint& j = joints_[joint];
    return (j.turns ? angle() : 1.0) * number(j.node, "springref", 0.0);
  }

  // Makes a joint depend on others; only linear laws can be joint variables.
  void follow(pugi::xml_node at, int joint, std::vector<FileJoint::Share> shares, double constant) {
    FileJoint& j = joints_[joint];
    if (j.follows) xml_.fail(at, "the joint '" + j.name + "' coupled twice", "at most one law for every joint");
    j.follows = true;
    j.shares = std::move(shares);
    j.constant = constant;
  }

  void read_couplings() {
    for (const pugi::xml_node section : root().children("equality")) {
      for (const pugi::xml_node law : section.children()) {
        const std::string kind = law.name();
        if (kind.empty() || std::strcmp(given(law, "active").value(), "false") == 0) continue;
        if (kind != "joint" && kind != "tendon")
          xml_.fail(law, "an equality of kind '" + kind + "', which closes a chain", "chains that end, and couplings of joints");
        const auto polynomial = numbers(law, "polycoef", 1, 5);
        for (std::size_t k = 2; k < polynomial.size(); ++k) {
          if (polynomial[k] != 0.0) xml_.fail(law, "a coupling that is not linear", "polycoef with two numbers");
        }
        const double c0 = polynomial.empty() ? 0.0 : polynomial[0];
        const double c1 = polynomial.size() < 2 ? 1.0 : polynomial[1];
        kind == "joint" ? couple_joints(law, c0, c1) : couple_tendon(law, c0);
      }
    }
  }

  // Couples joints by y - ref_y = c0 + c1 (x - ref_x), where the references are positions in the initial pose.
  void couple_joints(pugi::xml_node law, double c0, double c1) {
    const int y = find_joint(law, "joint1");
    if (!law.attribute("joint2")) {
      follow(law, y, {}, reference_position(y) + c0);
      return;
    }
    const int x = find_joint(law, "joint2");
    follow(law, y, {{x, c1}}, reference_position(y) + c0 - c1 * reference_position(x));
  }

  // Couples the joints of a tendon by length - length in the initial pose = c0; its first joint follows the
  // others.
  void couple_tendon(pugi::xml_node law, double c0) {
    if (law.attribute("tendon2")) xml_.fail(law, "an equality of two tendons", "one of a fixed tendon");
    const std::string name = law.attribute("tendon1").value();
    for (const pugi::xml_node section : root().children("tendon")) {
      const pugi::xml_node tendon = section.find_child_by_attribute("name", name.c_str());
      if (!tendon) continue;
      if (std::strcmp(tendon.name(), "fixed") != 0) xml_.fail(law, "an equality of a spatial tendon", "one of a fixed tendon");
      std::vector<FileJoint::Share> shares = terms(tendon);
      const FileJoint::Share own = shares.empty() ? FileJoint::Share{0, 0.0} : shares.front();
      if (own.coefficient == 0.0) xml_.fail(tendon, "no share of the first joint in a tendon", "coef other than zero");
      double constant = c0;
      for (const FileJoint::Share& s : shares) constant += s.coefficient * reference_position(s.joint);
      shares.erase(shares.begin());
      for (FileJoint::Share& s : shares) s.coefficient /= -own.coefficient;
      follow(law, own.joint, std::move(shares), constant / own.coefficient);
      return;
    }
    xml_.fail(law, "tendon1 '" + name + "'", "the name of a fixed tendon");
  }

  std::vector<FileJoint::Share> terms(pugi::xml_node tendon) const {
    std::vector<FileJoint::Share> out;
    for (const pugi::xml_node term : tendon.children("joint"))
      out.push_back({find_joint(term, "joint"), xml_.number(term, "coef", term.attribute("coef") ? term.attribute("coef").value() : "1")});
    return out;
  }

  // Reads the largest force of a joint's actuators, and the constant forces that they add.
  void read_actuators() {
    std::vector<double> force(joints_.size(), 0.0);
    for (const pugi::xml_node section : root().children("actuator")) {
      for (const pugi::xml_node motor : section.children()) {
        const char* transmission = motor.attribute("joint") ? "joint" : "jointinparent";
        if (!motor.attribute(transmission)) continue;
        const int j = find_joint(motor, transmission);
        const auto gears = numbers(motor, "gear", 1, 6);
        const double gear = gears.empty() ? 1.0 : gears[0];
        force[j] += largest_force(motor) * std::abs(gear);
        const auto bias = numbers(motor, "biasprm", 1, 10);
        const bool constant = bias.size() >= 1 && bias[0] != 0.0 && (bias.size() < 2 || bias[1] == 0.0) && (bias.size() < 3 || bias[2] == 0.0);
        if (constant && std::strcmp(given(motor, "biastype").value(), "affine") == 0) biases_.emplace_back(j, -gear * bias[0]);
      }
    }
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      if (force[j] > 0.0) joints_[j].limits.effort = std::min(joints_[j].limits.effort, force[j]);
    }
  }

  double largest_force(pugi::xml_node motor) const {
    double most = kInfinity;
    if (const auto range = numbers(motor, "forcerange", 2, 2); !range.empty() && limited(motor, "forcelimited"))
      most = std::max(std::abs(range[0]), std::abs(range[1]));
    const std::string kind = motor.name();
    const std::string bias = given(motor, "biastype").value();
    const std::string gain = given(motor, "gaintype").value();
    const auto slopes = numbers(motor, "biasprm", 1, 10);
    const bool servo = bias == "affine" && slopes.size() > 1 && (slopes[1] != 0.0 || (slopes.size() > 2 && slopes[2] != 0.0));
    const bool plain = kind == "motor" || (kind == "general" && !servo && bias != "muscle" && (gain.empty() || gain == "fixed"));
    const auto range = numbers(motor, "ctrlrange", 2, 2);
    if (!plain || range.empty() || !limited(motor, "ctrllimited")) return most;
    const auto gains = numbers(motor, "gainprm", 1, 10);
    return std::min(most, std::max(std::abs(range[0]), std::abs(range[1])) * std::abs(gains.empty() ? 1.0 : gains[0]));
  }

  void finish_frames() {
    for (std::size_t k = 0; k < model_.frames.size(); ++k) {
      Frame& frame = model_.frames[k];
      if (joint_of_frame_[k] < 0) continue;
      const Axis& variable = variables_[joint_of_frame_[k]];
      frame.variable.coefficients = variable.coefficients;
      frame.variable.offset += variable.offset;
    }
  }

  void add_nonnegative_effect(pugi::xml_node at, const char* attribute, const char* effect, Axis axis, double value) {
    if (value < 0.0) xml_.fail(at, text("a ", attribute, " of ", value), "one that is not negative");
    if (axis.coefficients.isZero(0.0)) return;
    if (std::strcmp(effect, "stiffness") != 0) axis.offset = 0.0;
    add_effect(model_, xml_.path(), effect, axis, value);
  }

  // Reads the forces that joints and fixed tendons of MuJoCo have in common.
  void passive_forces(pugi::xml_node node, const Axis& axis, double rest) {
    add_nonnegative_effect(node, "damping", "damping", axis, number(node, "damping", 0.0));
    add_nonnegative_effect(node, "frictionloss", "friction", axis, number(node, "frictionloss", 0.0));
    add_nonnegative_effect(node, "stiffness", "stiffness", {axis.coefficients, axis.offset - rest}, number(node, "stiffness", 0.0));
  }

  void read_joint_effects(std::size_t j) {
    const FileJoint& joint = joints_[j];
    passive_forces(joint.node, variables_[j], spring_reference(static_cast<int>(j)));
    add_nonnegative_effect(joint.node, "armature", "armature", variables_[j], number(joint.node, "armature", 0.0));
  }

  void read_tendons() {
    for (const pugi::xml_node section : root().children("tendon")) {
      for (const pugi::xml_node tendon : section.children()) {
        const std::string kind = tendon.name();
        if (kind != "fixed" && kind != "spatial") continue;
        const bool forces = number(tendon, "damping", 0.0) != 0.0 || number(tendon, "frictionloss", 0.0) != 0.0 ||
                            number(tendon, "stiffness", 0.0) != 0.0 || number(tendon, "armature", 0.0) != 0.0;
        if (!forces) continue;
        if (kind == "spatial" || number(tendon, "armature", 0.0) != 0.0)
          xml_.fail(tendon, text("forces of a ", kind, kind == "fixed" ? " tendon with armature" : " tendon"), "forces of joints and fixed tendons");
        Axis axis{VectorXd::Zero(model_.coordinates.size()), 0.0};
        double initial = 0.0;  // length with all joints at their spring references
        for (const FileJoint::Share& s : terms(tendon)) {
          axis.coefficients += s.coefficient * variables_[s.joint].coefficients;
          axis.offset += s.coefficient * variables_[s.joint].offset;
          initial += s.coefficient * spring_reference(s.joint);
        }
        const auto lengths = numbers(tendon, "springlength", 1, 2);
        if (lengths.size() == 2 && lengths[0] != lengths[1]) xml_.fail(tendon, "a spring with a dead band", "one length");
        const bool automatic = lengths.empty() || lengths[0] == -1.0;
        passive_forces(tendon, axis, automatic ? initial : lengths[0]);
      }
    }
  }

  void add_constant_force(int joint, double value) {
    Axis axis = variables_[joint];
    axis.offset = 0.0;
    if (!axis.coefficients.isZero(0.0)) add_effect(model_, xml_.path(), "offset", axis, value);
  }

  ModelDescription model_;
  std::set<std::string> names_;      // names of the frames
  std::vector<FileJoint> joints_;    // joints in the order of MuJoCo's qpos
  std::vector<int> joint_of_frame_;  // index of each frame's joint; -1: fixed
  std::vector<Axis> variables_;      // variable of each joint
  std::vector<std::pair<int, double>> biases_;
};

}  // namespace

Model read_mjcf(const std::string& path) {
  return MjcfReader(path).model();
}

}  // namespace veridyn
