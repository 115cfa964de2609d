#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <map>

#include "math/numbers.hpp"
#include "files/simulators/simulator_frames.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/simulator_files.hpp"

namespace veridyn {
namespace {

constexpr double kSdfUnlimited = 1e15;  // SDFormat writes 1e16 where there is no limit

class SdfReader {
 public:
  explicit SdfReader(const std::string& path) : xml_(path, "sdf", "an SDFormat file") {
    const std::string version = xml_.root().attribute("version").value();
    axes_in_model_ = version == "1.0" || version == "1.2" || version == "1.3" || version == "1.4";
    choose_model();
    for (const char* kind : {"include", "model"}) {
      if (const pugi::xml_node node = file_.child(kind))
        xml_.fail(node, text("<", kind, "> in a model"), "one model with all of its links (gz sdf -p prints one)");
    }
    if (text_of_child(file_, "static") == "true" || text_of_child(file_, "static") == "1") xml_.fail(file_, "a static model", "one that moves");
    if (file_.attribute("placement_frame")) xml_.fail(file_, "placement_frame", "a model placed by its own frame");
    for (const char* kind : {"link", "joint", "frame"}) {
      for (const pugi::xml_node node : file_.children(kind)) {
        const std::string name = node.attribute("name").value();
        if (name.empty()) xml_.fail(node, text("a ", kind, " without a name"), "one");
        if (!parts_.emplace(name, node).second) xml_.fail(node, text("a second part '", name, "'"), "names that are unique");
      }
    }
  }

  Model model() {
    model_.name = file_.attribute("name").value();
    model_.source = xml_.path();
    model_.values = RobotValues::kPrior;
    T_world_model_ = file_.child("pose") ? pose_of_element(file_.child("pose")) : Eigen::Isometry3d::Identity();
    for (const pugi::xml_node node : file_.children("joint")) read_joint(node);
    for (std::size_t j = 0; j < joints_.size(); ++j) follow(j);
    variables_ = joint_variables(xml_, joints_, model_.coordinates);
    for (const pugi::xml_node node : file_.children("link")) add_link(node, 0);
    for (std::size_t j = 0; j < joints_.size(); ++j) read_effects(j);
    return Model(std::move(model_));
  }

 private:
  static std::string text_of_child(pugi::xml_node node, const char* child) { return node.child(child).text().get(); }

  // Chooses the only model with moving joints; it may be in a world.
  void choose_model() {
    std::vector<pugi::xml_node> found;
    const auto search_models_in = [&](pugi::xml_node above) {
      for (const pugi::xml_node model : above.children("model")) {
        if (model.find_node([](const pugi::xml_node& n) { return std::strcmp(n.name(), "joint") == 0; })) found.push_back(model);
      }
    };
    search_models_in(xml_.root());
    for (const pugi::xml_node world : xml_.root().children("world")) {
      search_models_in(world);
      if (const pugi::xml_node g = world.child("gravity")) {
        const auto v = xml_.numbers(g, "gravity", g.text().get(), 3, 3);
        model_.gravity = {v[0], v[1], v[2]};
      }
    }
    if (found.empty()) xml_.fail(xml_.root(), "no model with joints", "one");
    if (found.size() > 1) xml_.fail(found[1], text("a second model with joints, '", found[1].attribute("name").value(), "'"), "one");
    file_ = found.front();
  }

  // The number in a child element, infinite ones included, or `otherwise` without such an element.
  double number(pugi::xml_node node, const char* child, double otherwise) const {
    const pugi::xml_node element = node.child(child);
    return element ? xml_.number(element, child, element.text().get()) : otherwise;
  }

  // As number(), but refuses infinite numbers.
  double finite_number(pugi::xml_node node, const char* child, double otherwise) const {
    const pugi::xml_node element = node.child(child);
    return element ? xml_.numbers(element, child, element.text().get(), 1, 1)[0] : otherwise;
  }

  // Reads "x y z roll pitch yaw", in degrees or as a quaternion if the element says so.
  Eigen::Isometry3d pose_of_element(pugi::xml_node pose) const {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    const std::string format = pose.attribute("rotation_format").value();
    const std::string words = pose.text().get();
    if (words.find_first_not_of(" \t\r\n") == std::string::npos) return T;
    const bool quaternion = format == "quat_xyzw";
    const auto v = xml_.numbers(pose, "pose", words, quaternion ? 7 : 6, quaternion ? 7 : 6);
    T.translation() = Eigen::Vector3d(v[0], v[1], v[2]);
    if (quaternion) {
      const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
      if (!(q.norm() > 1e-10)) xml_.fail(pose, "a quaternion of zero length", "a rotation");
      T.linear() = q.normalized().toRotationMatrix();
      return T;
    }
    const std::string degrees = pose.attribute("degrees").value();
    const double unit = degrees == "true" || degrees == "1" ? M_PI / 180.0 : 1.0;
    T.linear() = eigen(rotation_from_rpy({unit * v[3], unit * v[4], unit * v[5]}));
    return T;
  }

  // The pose of a link, joint or frame in the model at zero.
  Eigen::Isometry3d place_of(pugi::xml_node user, const std::string& name, std::size_t depth) const {
    if (name == "__model__") return Eigen::Isometry3d::Identity();
    if (name == "world") return T_world_model_.inverse(Eigen::Isometry);
    const auto found = parts_.find(name);
    if (found == parts_.end()) xml_.fail(user, "the name '" + name + "'", "that of a link, joint or frame of this model");
    const pugi::xml_node node = found->second;
    if (depth > parts_.size()) xml_.fail(node, "the pose of '" + name + "' in a cycle", "one that ends at the model");
    const pugi::xml_node pose = node.child("pose");
    std::string base = pose.attribute("relative_to").value();
    if (base.empty()) base = pose.attribute("frame").value();  // name of the attribute in SDFormat 1.5 and 1.6
    if (base.empty()) {
      base = std::strcmp(node.name(), "joint") == 0 ? text_of_child(node, "child") : node.attribute("attached_to").value();
      if (base.empty()) base = "__model__";
    }
    const Eigen::Isometry3d T = place_of(node, base, depth + 1);
    return pose ? T * pose_of_element(pose) : T;
  }

  // The link that moves with a link, joint or frame.
  std::string link_of(pugi::xml_node user, const std::string& name, std::size_t depth) const {
    if (name == "world" || name == "__model__") return name;
    const auto found = parts_.find(name);
    if (found == parts_.end() || depth > parts_.size()) xml_.fail(user, "the name '" + name + "'", "that of a link of this model");
    const pugi::xml_node node = found->second;
    if (std::strcmp(node.name(), "link") == 0) return name;
    if (std::strcmp(node.name(), "joint") == 0) return link_of(node, text_of_child(node, "child"), depth + 1);
    const std::string base = node.attribute("attached_to").value();
    return link_of(node, base.empty() ? "__model__" : base, depth + 1);
  }

  static bool is_fixed(pugi::xml_node joint) { return std::strcmp(joint.attribute("type").value(), "fixed") == 0; }

  void read_joint(pugi::xml_node node) {
    const std::string type = node.attribute("type").value();
    const std::string name = node.attribute("name").value();
    if (type != "revolute" && type != "continuous" && type != "prismatic" && type != "fixed")
      xml_.fail(node, "a joint of type '" + type + "'", "revolute, continuous, prismatic or fixed");
    const std::string child = link_of(node, text_of_child(node, "child"), 0);
    if (!above_.emplace(child, node).second)
      xml_.fail(node, "the joint '" + name + "', a second one above the link '" + child + "'", "no closed chain");
    if (type == "fixed") return;
    FileJoint joint;
    joint.node = node;
    joint.name = name;
    joint.turns = type != "prismatic";
    joint.limits = {-kInfinity, kInfinity, kInfinity, kInfinity, kInfinity};
    const pugi::xml_node axis = node.child("axis");
    const pugi::xml_node limit = axis.child("limit");
    const double lower = number(limit, "lower", -kInfinity), upper = number(limit, "upper", kInfinity);
    if (!(lower <= upper)) xml_.fail(limit, text("limits [", lower, ", ", upper, "]"), "lower < upper");
    if (type != "continuous" && lower > -kSdfUnlimited && lower < upper) joint.limits.lower = lower;
    if (type != "continuous" && upper < kSdfUnlimited && lower < upper) joint.limits.upper = upper;
    const double velocity = number(limit, "velocity", -1.0), effort = number(limit, "effort", -1.0);
    if (velocity > 0.0 && velocity < kSdfUnlimited) joint.limits.velocity = velocity;
    if (effort > 0.0 && effort < kSdfUnlimited) joint.limits.effort = effort;
    joints_.push_back(joint);
  }

  // Makes a joint mimic another one: variable = multiplier (leader - reference) + offset.
  void follow(std::size_t j) {
    const pugi::xml_node mimic = joints_[j].node.child("axis").child("mimic");
    if (!mimic) return;
    const std::string leader = mimic.attribute("joint").value();
    for (std::size_t other = 0; other < joints_.size(); ++other) {
      if (joints_[other].name != leader) continue;
      const double multiplier = finite_number(mimic, "multiplier", 1.0);
      joints_[j].follows = true;
      joints_[j].shares = {{static_cast<int>(other), multiplier}};
      joints_[j].constant = finite_number(mimic, "offset", 0.0) - multiplier * finite_number(mimic, "reference", 0.0);
      return;
    }
    xml_.fail(mimic, "mimic of the joint '" + leader + "'", "a joint that moves");
  }

  int frame_of(const std::string& link) const {
    for (std::size_t k = 0; k < model_.frames.size(); ++k) {
      if (model_.frames[k].name == link) return static_cast<int>(k);
    }
    return -1;
  }

  // Adds a link after its ancestors.
  void add_link(pugi::xml_node node, std::size_t depth) {
    const std::string name = node.attribute("name").value();
    if (frame_of(name) >= 0) return;
    Frame frame;
    frame.name = name;
    const auto above = above_.find(name);
    const Eigen::Isometry3d T_model_link = place_of(node, name, 0);
    if (above == above_.end()) {
      place(frame, {from_eigen(T_world_model_ * T_model_link), {0, 0, 1}, {0, 0, 0}});
    } else {
      if (depth > parts_.size()) xml_.fail(node, "the link '" + name + "' in a cycle of joints", "chains that end");
      place_below(above->second, frame, T_model_link, depth);
    }
    frame.body = body(node);
    model_.frames.push_back(std::move(frame));
  }

  void place_below(pugi::xml_node joint, Frame& frame, const Eigen::Isometry3d& T_model_link, std::size_t depth) {
    const std::string parent = link_of(joint, text_of_child(joint, "parent"), 0);
    Eigen::Isometry3d T_parent_model = T_world_model_;
    if (parent != "world" && parent != "__model__") {
      add_link(parts_.at(parent), depth + 1);
      frame.parent = FrameIndex{frame_of(parent)};
      T_parent_model = place_of(joint, parent, 0).inverse(Eigen::Isometry);
    }
    if (is_fixed(joint)) {
      place(frame, {from_eigen(T_parent_model * T_model_link), {0, 0, 1}, {0, 0, 0}});
      return;
    }
    const auto j = static_cast<std::size_t>(index_of(joint));
    frame.type = joints_[j].turns ? JointType::kRevolute : JointType::kPrismatic;
    frame.variable = variables_[j];
    // The joint's axis is given in its frame, whereas JointPlacement needs it in the axes of the link.
    const Eigen::Isometry3d T_model_joint = place_of(joint, joint.attribute("name").value(), 0);
    const Eigen::Isometry3d T_joint_link = T_model_joint.inverse(Eigen::Isometry) * T_model_link;
    const Eigen::Matrix3d R = T_joint_link.linear();
    Eigen::Isometry3d origin = T_parent_model * T_model_joint;
    origin.linear() = (origin.linear() * R).eval();
    const Eigen::Vector3d axis = R.transpose() * axis_of(joint, T_model_joint.linear());
    const Eigen::Vector3d tip = R.transpose() * T_joint_link.translation();
    place(frame, {from_eigen(origin), unit_axis(xml_, joint, axis), {tip.x(), tip.y(), tip.z()}});
  }

  int index_of(pugi::xml_node joint) const {
    int j = 0;
    while (joints_[j].node != joint) ++j;
    return j;
  }

  // The axis in the joint's frame.
  Eigen::Vector3d axis_of(pugi::xml_node joint, const Eigen::Matrix3d& R_model_joint) const {
    const pugi::xml_node axis = joint.child("axis");
    const pugi::xml_node xyz = axis.child("xyz");
    if (!xyz) {
      if (axis) return Eigen::Vector3d::UnitZ();
      xml_.fail(joint, text("the joint '", joint.attribute("name").value(), "' without an axis"), "one");
    }
    const auto v = xml_.numbers(xyz, "xyz", xyz.text().get(), 3, 3);
    const Eigen::Vector3d u(v[0], v[1], v[2]);
    const std::string in_model = text_of_child(axis, "use_parent_model_frame");
    const std::string base = xyz.attribute("expressed_in").value();
    // Up to SDFormat 1.4, axes were given in the frame of the model.
    if (in_model == "true" || in_model == "1" || axes_in_model_) return R_model_joint.transpose() * u;
    if (!base.empty()) return R_model_joint.transpose() * place_of(xyz, base, 0).linear() * u;
    return u;
  }

  // SDFormat gives a link without values a mass of 1 kg and moments of 1 kg m^2.
  std::optional<Body> body(pugi::xml_node link) const {
    if (text_of_child(link, "gravity") == "false" || text_of_child(link, "gravity") == "0") xml_.fail(link, "a link without gravity", "one with it");
    const pugi::xml_node inertial = link.child("inertial");
    const std::string automatic = inertial.attribute("auto").value();
    if (automatic == "true" || automatic == "1") xml_.fail(inertial, "inertia computed from collisions", "its values");
    if (inertial.child("fluid_added_mass")) xml_.fail(inertial.child("fluid_added_mass"), "added mass of a fluid", "none");
    const pugi::xml_node entries = inertial.child("inertia");
    const double xx = finite_number(entries, "ixx", 1.0), yy = finite_number(entries, "iyy", 1.0), zz = finite_number(entries, "izz", 1.0);
    const double xy = finite_number(entries, "ixy", 0.0), xz = finite_number(entries, "ixz", 0.0), yz = finite_number(entries, "iyz", 0.0);
    Eigen::Matrix3d I;
    I << xx, xy, xz, xy, yy, yz, xz, yz, zz;
    const pugi::xml_node pose = inertial.child("pose");
    Eigen::Isometry3d T = pose ? pose_of_element(pose) : Eigen::Isometry3d::Identity();
    const std::string base = pose.attribute("relative_to").value();
    if (!base.empty())
      T = place_of(link, link.attribute("name").value(), 0).inverse(Eigen::Isometry) * place_of(pose, base, 0) * T;
    return body_of(xml_, inertial ? inertial : link, finite_number(inertial, "mass", 1.0), T, I);
  }

  void read_effects(std::size_t j) {
    const pugi::xml_node dynamics = joints_[j].node.child("axis").child("dynamics");
    const Axis axis{variables_[j].coefficients, 0.0};
    if (axis.coefficients.isZero(0.0)) return;
    const auto add = [&](const char* element, const char* effect, const Axis& along) {
      const double value = finite_number(dynamics, element, 0.0);
      if (value < 0.0) xml_.fail(dynamics.child(element), text("a ", element, " of ", value), "one that is not negative");
      add_effect(model_, xml_.path(), effect, along, value);
    };
    add("damping", "damping", axis);
    add("friction", "friction", axis);
    add("spring_stiffness", "stiffness", {axis.coefficients, variables_[j].offset - finite_number(dynamics, "spring_reference", 0.0)});
  }

  XmlFile xml_;
  bool axes_in_model_ = false;
  pugi::xml_node file_;
  ModelDescription model_;
  Eigen::Isometry3d T_world_model_ = Eigen::Isometry3d::Identity();
  std::map<std::string, pugi::xml_node> parts_;  // links, joints and frames by name
  std::map<std::string, pugi::xml_node> above_;  // the joint above each link
  std::vector<FileJoint> joints_;                // moving joints
  std::vector<Axis> variables_;
};

}  // namespace

Model read_sdf(const std::string& path) {
  return SdfReader(path).model();
}

}  // namespace veridyn
