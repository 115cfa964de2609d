#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>

#include "math/numbers.hpp"
#include "model/simulators/simulator_frames.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/model/simulator_files.hpp"

namespace veridyn {
namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr double kMjcfDensity = 1000.0;  // [kg/m^3] MuJoCo's default for geoms

Eigen::Vector3d vector3(const std::vector<double>& v) {
  return {v[0], v[1], v[2]};
}

class MjcfReader {
 public:
  explicit MjcfReader(const std::string& path) : xml_(path, "mujoco", "an MJCF file") {
    const pugi::xml_node other = root().find_node([](const pugi::xml_node& n) {
      return std::strcmp(n.name(), "include") == 0 || std::strcmp(n.name(), "attach") == 0;
    });
    if (other) {
      xml_.fail(other, text("<", other.name(), "> of '", other.attribute("file").value(), "'"),
                "one file with all of the arm (MuJoCo writes one: mj_saveLastXML)");
    }
    read_compiler();
    read_option();
  }

  Model model() {
    model_.name = root().attribute("model") ? root().attribute("model").value() : "MuJoCo Model";
    model_.source = xml_.path();
    model_.values = RobotValues::kPrior;
    for (const pugi::xml_node world : root().children("worldbody")) {
      for (const char* kind : {"joint", "freejoint", "inertial"}) {
        if (const pugi::xml_node node = world.child(kind))
          xml_.fail(node, text("<", kind, "> in the worldbody"), "it inside of a body");
      }
      children(world, -1, Eigen::Isometry3d::Identity(), false);
    }
    read_couplings();
    read_actuators();
    variables_ = joint_variables(xml_, joints_, model_.coordinates);
    finish_frames();
    for (std::size_t j = 0; j < joints_.size(); ++j) joint_effects(j);
    read_tendons();
    for (const auto& [joint, bias] : biases_) constant_force(joint, bias);
    return Model(std::move(model_));
  }

 private:
  pugi::xml_node root() const { return xml_.root(); }

  // The last value of an attribute among all sections of a name.
  pugi::xml_attribute setting(const char* section, const char* name, pugi::xml_node* where = nullptr) const {
    pugi::xml_attribute out;
    for (const pugi::xml_node node : root().children(section)) {
      if (const pugi::xml_attribute own = node.attribute(name)) {
        out = own;
        if (where != nullptr) *where = node;
      }
    }
    return out;
  }

  static bool is_true(pugi::xml_attribute a) { return std::strcmp(a.value(), "true") == 0; }

  void read_compiler() {
    pugi::xml_node at = root().child("compiler");
    for (const char* name : {"boundmass", "boundinertia", "settotalmass"}) {
      const pugi::xml_attribute given = setting("compiler", name, &at);
      if (given && xml_.number(at, name, given.value()) > 0.0)
        xml_.fail(at, text("the compiler's ", name, ", which changes bodies"), "bodies as they are");
    }
    const std::string coordinate = setting("compiler", "coordinate", &at).value();
    if (coordinate == "global") xml_.fail(at, "global coordinates", "local ones");
    const std::string angle = setting("compiler", "angle", &at).value();
    if (!angle.empty() && angle != "degree" && angle != "radian") xml_.fail(at, "angle '" + angle + "'", "degree or radian");
    angle_ = angle == "radian" ? 1.0 : kDegree;
    if (const pugi::xml_attribute given = setting("compiler", "eulerseq", &at)) sequence_ = given.value();
    if (sequence_.size() != 3 || sequence_.find_first_not_of("xyzXYZ") != std::string::npos)
      xml_.fail(at, "eulerseq '" + sequence_ + "'", "three letters of x, y, z, X, Y, Z");
    const std::string limits = setting("compiler", "autolimits").value();
    auto_limits_ = limits != "false";
    geoms_always_ = is_true(setting("compiler", "inertiafromgeom"));
    geoms_never_ = std::strcmp(setting("compiler", "inertiafromgeom").value(), "false") == 0;
    if (const pugi::xml_attribute given = setting("compiler", "inertiagrouprange", &at)) {
      const auto range = xml_.numbers(at, "inertiagrouprange", given.value(), 2, 2);
      first_group_ = range[0];
      last_group_ = range[1];
    }
  }

  void read_option() {
    pugi::xml_node at = root().child("option");
    if (const pugi::xml_attribute given = setting("option", "gravity", &at))
      model_.gravity = vector3(xml_.numbers(at, "gravity", given.value(), 3, 3));
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

  // The defaults of a class: the element <default> of that name.
  pugi::xml_node defaults(pugi::xml_node user, const std::string& name) const {
    for (const pugi::xml_node top : root().children("default")) {
      const std::string own = top.attribute("class") ? top.attribute("class").value() : "main";
      if (own == name) return top;
      const pugi::xml_node below = top.find_node([&](const pugi::xml_node& n) {
        return std::strcmp(n.name(), "default") == 0 && name == n.attribute("class").value();
      });
      if (below) return below;
    }
    if (name != "main") xml_.fail(user, "the class '" + name + "'", "one that <default> defines");
    return {};
  }

  // An attribute of an element, or that of its class' defaults.
  pugi::xml_attribute given(pugi::xml_node node, const char* name) const {
    if (const pugi::xml_attribute own = node.attribute(name)) return own;
    std::string used = node.attribute("class").value();
    for (pugi::xml_node above = node.parent(); used.empty() && above; above = above.parent())
      used = above.attribute("childclass").value();
    pugi::xml_node from = defaults(node, used.empty() ? "main" : used);
    for (; from && std::strcmp(from.name(), "default") == 0; from = from.parent()) {
      if (const pugi::xml_attribute inherited = from.child(node.name()).attribute(name)) return inherited;
    }
    // Several top-level sections <default> make up the class main.
    for (const pugi::xml_node top : root().children("default")) {
      if (const pugi::xml_attribute inherited = top.child(node.name()).attribute(name)) return inherited;
    }
    return {};
  }

  double number(pugi::xml_node node, const char* name, double otherwise) const {
    const pugi::xml_attribute a = given(node, name);
    return a ? xml_.numbers(node, name, a.value(), 1, 1)[0] : otherwise;
  }

  std::vector<double> numbers(pugi::xml_node node, const char* name, int least, int most) const {
    const pugi::xml_attribute a = given(node, name);
    return a ? xml_.numbers(node, name, a.value(), least, most) : std::vector<double>();
  }

  Eigen::Vector3d direction(pugi::xml_node node, const char* name, const std::vector<double>& v) const {
    if (const double length = vector3(v).norm(); length > 1e-10) return vector3(v) / length;
    xml_.fail(node, text(name, " without a direction"), "a vector that is not zero");
  }

  Eigen::Matrix3d orientation(pugi::xml_node node) const {
    if (const auto q = numbers(node, "quat", 4, 4); !q.empty()) {
      const Eigen::Quaterniond turn(q[0], q[1], q[2], q[3]);
      if (!(turn.norm() > 1e-10)) xml_.fail(node, "a quaternion of zero length", "a rotation");
      return turn.normalized().toRotationMatrix();
    }
    if (const auto a = numbers(node, "axisangle", 4, 4); !a.empty())
      return Eigen::AngleAxisd(angle_ * a[3], direction(node, "axisangle", a)).toRotationMatrix();
    if (const auto e = numbers(node, "euler", 3, 3); !e.empty()) {
      Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
      for (std::size_t k = 0; k < 3; ++k) {
        const bool fixed_axes = sequence_[k] < 'a';
        const Eigen::Matrix3d turn =
            Eigen::AngleAxisd(angle_ * e[k], Eigen::Vector3d::Unit((fixed_axes ? sequence_[k] + 32 : sequence_[k]) - 'x'))
                .toRotationMatrix();
        R = fixed_axes ? Eigen::Matrix3d(turn * R) : Eigen::Matrix3d(R * turn);
      }
      return R;
    }
    if (const auto v = numbers(node, "xyaxes", 6, 6); !v.empty()) {
      Eigen::Matrix3d R;
      R.col(0) = direction(node, "xyaxes", v);
      const Eigen::Vector3d y(v[3], v[4], v[5]);
      R.col(1) = y - R.col(0).dot(y) * R.col(0);
      if (!(R.col(1).norm() > 1e-10)) xml_.fail(node, "xyaxes that are parallel", "two directions");
      R.col(1).normalize();
      R.col(2) = R.col(0).cross(R.col(1));
      return R;
    }
    if (const auto z = numbers(node, "zaxis", 3, 3); !z.empty()) return turn_z_to(direction(node, "zaxis", z));
    return Eigen::Matrix3d::Identity();
  }

  // The shortest rotation that takes z to a unit vector.
  static Eigen::Matrix3d turn_z_to(const Eigen::Vector3d& z) {
    const Eigen::Vector3d normal = Eigen::Vector3d::UnitZ().cross(z);
    const double sine = normal.norm();
    const Eigen::Vector3d axis = sine < 1e-10 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d(normal / sine);
    return Eigen::AngleAxisd(std::atan2(sine, z.z()), axis).toRotationMatrix();
  }

  Eigen::Isometry3d pose(pugi::xml_node node) const {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    if (const auto p = numbers(node, "pos", 3, 3); !p.empty()) T.translation() = vector3(p);
    T.linear() = orientation(node);
    return T;
  }

  std::string free_name(const std::string& wanted) {
    std::string name = wanted;
    for (int k = 2; !names_.insert(name).second; ++k) name = wanted + "_" + std::to_string(k);
    return name;
  }

  void add_frame(Frame frame, int joint) {
    model_.frames.push_back(std::move(frame));
    joint_of_frame_.push_back(joint);
  }

  // Bodies and sites below a body. `T` places the body's own axes in the frame `parent`.
  void children(pugi::xml_node above, int parent, const Eigen::Isometry3d& T, bool moves) {
    for (const pugi::xml_node node : above.children()) {
      const std::string kind = node.name();
      if (kind == "body") body(node, parent, T, moves);
      if (kind == "frame") {
        for (const char* inner : {"joint", "freejoint", "inertial"}) {
          if (const pugi::xml_node in = node.child(inner)) xml_.fail(in, text("<", inner, "> in a <frame>"), "it in its body");
        }
        children(node, parent, T * pose(node), moves);
      }
      if (kind == "site" && *node.attribute("name").value() != 0 && !is_body_site(node)) site(node, parent, T * pose(node));
      if (kind == "composite" || kind == "flexcomp" || kind == "replicate")
        xml_.fail(node, "<" + kind + ">", "bodies, joints and geoms one by one");
    }
  }

  // A site of its body's own name is the place of the body's frame, as in exported files.
  static bool is_body_site(pugi::xml_node node) {
    return std::strcmp(node.parent().name(), "body") == 0 &&
           std::strcmp(node.attribute("name").value(), node.parent().attribute("name").value()) == 0;
  }

  void site(pugi::xml_node node, int parent, const Eigen::Isometry3d& T) {
    Frame frame;
    frame.name = free_name(node.attribute("name").value());
    frame.parent = parent;
    place(frame, {posed(T), {0, 0, 1}, {0, 0, 0}});
    add_frame(std::move(frame), -1);
  }

  void body(pugi::xml_node node, int parent, const Eigen::Isometry3d& before, bool moves) {
    if (node.child("freejoint")) xml_.fail(node.child("freejoint"), "a body that moves freely", "arms on a fixed base");
    if (const pugi::xml_attribute a = node.attribute("gravcomp"); a && xml_.number(node, "gravcomp", a.value()) != 0.0)
      xml_.fail(node, "gravity compensation of a body (gravcomp)", "none: motors carry the weight");
    const std::string own = node.attribute("name").value();
    const std::string name = free_name(own.empty() ? "body_" + std::to_string(model_.frames.size() + 1) : own);
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
      frame.name = last ? name : free_name(name + "__" + joints_[index].name);
      if (last) frame.B = frame.B * posed(T_body_frame);
      parent = static_cast<int>(model_.frames.size());
      add_frame(std::move(frame), index);
      T = Eigen::Isometry3d::Identity();
    }
    if (joints.empty()) {
      Frame frame;
      frame.name = name;
      frame.parent = parent;
      place(frame, {posed(T * T_body_frame), {0, 0, 1}, {0, 0, 0}});
      parent = static_cast<int>(model_.frames.size());
      add_frame(std::move(frame), -1);
    }
    moves = moves || !joints.empty();
    const Eigen::Isometry3d T_frame_body = T_body_frame.inverse(Eigen::Isometry);
    model_.frames[parent].body = inertia(node, T_frame_body, moves);
    children(node, parent, T_frame_body, moves);
  }

  // A joint of a body whose axes lie at T at zero; sets the frame's type and placement.
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
    const double unit = out.turns ? angle_ : 1.0;
    out.limits = {-kInfinity, kInfinity, kInfinity, kInfinity, kInfinity};
    if (const auto range = numbers(node, "range", 2, 2); !range.empty() && limited(node, "limited")) {
      if (!(range[0] < range[1])) xml_.fail(node, text("the range ", range[0], " ", range[1]), "lower < upper");
      out.limits.lower = unit * range[0];
      out.limits.upper = unit * range[1];
    }
    if (const auto force = numbers(node, "actuatorfrcrange", 2, 2); !force.empty() && limited(node, "actuatorfrclimited"))
      out.limits.effort = std::max(std::abs(force[0]), std::abs(force[1]));
    const auto p = numbers(node, "pos", 3, 3);
    const Eigen::Vector3d at = p.empty() ? Eigen::Vector3d(0, 0, 0) : vector3(p);
    const auto axis = numbers(node, "axis", 3, 3);
    frame.type = out.turns ? JointType::kRevolute : JointType::kPrismatic;
    place(frame, {posed(T * Eigen::Translation3d(at)),
                  unit_axis(xml_, node, axis.empty() ? Eigen::Vector3d(0, 0, 1) : vector3(axis)),
                  {-at.x(), -at.y(), -at.z()}});
    frame.variable.offset = -unit * number(node, "ref", 0.0);
    joints_.push_back(out);
    return static_cast<int>(joints_.size()) - 1;
  }

  // True where a range is a limit.
  bool limited(pugi::xml_node node, const char* name) const {
    const std::string words = given(node, name).value();
    return words == "true" || (words != "false" && auto_limits_);
  }

  std::optional<Body> inertia(pugi::xml_node node, const Eigen::Isometry3d& T_frame_body, bool moves) const {
    const pugi::xml_node own = node.child("inertial");
    if (!own || geoms_always_) return geoms_never_ || !moves ? std::nullopt : inertia_of_geoms(node, T_frame_body);
    if (!own.attribute("mass")) xml_.fail(own, "no mass of a body", "one");
    const double mass = number(own, "mass", 0.0);
    Eigen::Matrix3d I = Eigen::Matrix3d::Zero();
    if (const auto full = numbers(own, "fullinertia", 6, 6); !full.empty()) {
      I << full[0], full[3], full[4], full[3], full[1], full[5], full[4], full[5], full[2];
    } else if (const auto diagonal = numbers(own, "diaginertia", 3, 3); !diagonal.empty()) {
      I.diagonal() = vector3(diagonal);
    } else {
      xml_.fail(own, "no moments of inertia", "diaginertia or fullinertia");
    }
    return body_of(xml_, own, mass, T_frame_body * pose(own), I);
  }

  // The sum of a body's geoms of uniform density.
  std::optional<Body> inertia_of_geoms(pugi::xml_node node, const Eigen::Isometry3d& T_frame_body) const {
    std::optional<Body> sum;
    for (const pugi::xml_node part : node.children()) {
      if (std::strcmp(part.name(), "frame") == 0) {
        const std::optional<Body> below = inertia_of_geoms(part, T_frame_body * pose(part));
        if (below && sum) *sum->phi += *below->phi;
        if (below && !sum) sum = below;
      }
      if (std::strcmp(part.name(), "geom") != 0) continue;
      const double group = number(part, "group", 0.0);
      if (group < first_group_ || group > last_group_) continue;
      const std::optional<Body> one = geom(part, T_frame_body);
      if (one && sum) *sum->phi += *one->phi;
      if (one && !sum) sum = one;
    }
    return sum;
  }

  std::optional<Body> geom(pugi::xml_node node, const Eigen::Isometry3d& T_frame_body) const {
    const std::string type = given(node, "type") ? given(node, "type").value() : "sphere";
    const double density = number(node, "density", kMjcfDensity);
    const double mass = number(node, "mass", -1.0);
    if (mass == 0.0 || (mass < 0.0 && density == 0.0)) return std::nullopt;
    if (is_true(given(node, "shellinertia"))) xml_.fail(node, "the inertia of a shell", "an <inertial> in its body");
    const auto ends = numbers(node, "fromto", 6, 6);
    const bool long_shape = type == "capsule" || type == "cylinder" || type == "box" || type == "ellipsoid";
    const std::size_t needed = type == "sphere" ? 1 : type == "box" || type == "ellipsoid" ? 3 : 2;
    if (!long_shape && type != "sphere") {
      xml_.fail(node, text("a body without <inertial>, whose inertia MuJoCo infers from a ", type),
                "<inertial> in its body (MuJoCo writes one: mj_saveLastXML)");
    }
    auto size = numbers(node, "size", 1, 3);
    Eigen::Isometry3d T = pose(node);
    if (!ends.empty() && long_shape) {
      const Eigen::Vector3d from = vector3(ends), to(ends[3], ends[4], ends[5]);
      if (!((to - from).norm() > 0.0)) xml_.fail(node, "a geom between two equal points", "two points");
      T.translation() = 0.5 * (from + to);
      T.linear() = turn_z_to((from - to).normalized());
      const double radius = size.empty() ? 0.0 : size[0];
      size = needed == 3 ? std::vector<double>{radius, radius} : std::vector<double>{radius};
      size.push_back(0.5 * (to - from).norm());
    }
    if (size.size() < needed || *std::min_element(size.begin(), size.end()) < 0.0 || !(size[0] > 0.0))
      xml_.fail(node, text("a ", type, " without its sizes"), text(needed, needed == 1 ? " number" : " numbers", " above zero"));
    const SolidShape solid = solid_of(type, size);
    const double m = mass > 0.0 ? mass : density * solid.volume;
    Eigen::Matrix3d I = Eigen::Matrix3d::Zero();
    I.diagonal() = m * solid.gyration;
    return body_of(xml_, node, m, T_frame_body * T, I);
  }

  // Volume [m^3] and squared radii of gyration [m^2] about the principal axes.
  struct SolidShape {
    double volume;
    Eigen::Vector3d gyration;
  };

  static SolidShape solid_of(const std::string& type, const std::vector<double>& size) {
    const double r = size[0];
    if (type == "sphere") return {4.0 / 3.0 * M_PI * r * r * r, Eigen::Vector3d::Constant(0.4 * r * r)};
    if (type == "box" || type == "ellipsoid") {
      const double x = size[0] * size[0], y = size[1] * size[1], z = size[2] * size[2];
      const bool box = type == "box";
      return {(box ? 8.0 : 4.0 / 3.0 * M_PI) * size[0] * size[1] * size[2],
              Eigen::Vector3d(y + z, x + z, x + y) / (box ? 3.0 : 5.0)};
    }
    const double h = size[1];
    const double tube = 2.0 * M_PI * r * r * h;
    const double across = r * r / 4.0 + h * h / 3.0;
    if (type == "cylinder") return {tube, {across, across, r * r / 2.0}};
    // A capsule is a cylinder between two halves of a sphere, whose centres lie 3/8 r beyond its ends.
    const double ball = 4.0 / 3.0 * M_PI * r * r * r;
    const double all = tube + ball;
    const double ends = 0.4 * r * r + h * h + 0.75 * h * r;
    const double x = (tube * across + ball * ends) / all;
    return {all, {x, x, (tube * r * r / 2.0 + ball * 0.4 * r * r) / all}};
  }

  int find_joint(pugi::xml_node at, const char* attribute) const {
    const std::string name = at.attribute(attribute).value();
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      if (joints_[j].name == name) return static_cast<int>(j);
    }
    xml_.fail(at, text(attribute, " '", name, "'"), "the name of a hinge or slide");
  }

  double ref(int joint) const {
    const FileJoint& j = joints_[joint];
    return (j.turns ? angle_ : 1.0) * number(j.node, "ref", 0.0);
  }

  double spring_reference(int joint) const {
    const FileJoint& j = joints_[joint];
    return (j.turns ? angle_ : 1.0) * number(j.node, "springref", 0.0);
  }

  // Makes a joint follow others; only linear laws are joint variables.
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

  // y - ref_y = c0 + c1 (x - ref_x), where the references are positions in the initial pose.
  void couple_joints(pugi::xml_node law, double c0, double c1) {
    const int y = find_joint(law, "joint1");
    if (!law.attribute("joint2")) {
      follow(law, y, {}, ref(y) + c0);
      return;
    }
    const int x = find_joint(law, "joint2");
    follow(law, y, {{x, c1}}, ref(y) + c0 - c1 * ref(x));
  }

  // length - length in the initial pose = c0; the tendon's first joint follows the others.
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
      for (const FileJoint::Share& s : shares) constant += s.coefficient * ref(s.joint);
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

  // The largest force of a joint's actuators, and constant forces that they add.
  void read_actuators() {
    std::vector<double> force(joints_.size(), 0.0);
    std::vector<char> known(joints_.size(), 1);
    for (const pugi::xml_node section : root().children("actuator")) {
      for (const pugi::xml_node motor : section.children()) {
        const char* transmission = motor.attribute("joint") ? "joint" : "jointinparent";
        if (!motor.attribute(transmission)) continue;
        const int j = find_joint(motor, transmission);
        const auto gears = numbers(motor, "gear", 1, 6);
        const double gear = gears.empty() ? 1.0 : gears[0];
        const double most = largest_force(motor) * std::abs(gear);
        force[j] += most;
        if (most == kInfinity) known[j] = 0;
        const auto bias = numbers(motor, "biasprm", 1, 10);
        const bool constant = bias.size() >= 1 && bias[0] != 0.0 && (bias.size() < 2 || bias[1] == 0.0) && (bias.size() < 3 || bias[2] == 0.0);
        if (constant && std::strcmp(given(motor, "biastype").value(), "affine") == 0) biases_.emplace_back(j, -gear * bias[0]);
      }
    }
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      if (known[j] != 0 && force[j] > 0.0) joints_[j].limits.effort = std::min(joints_[j].limits.effort, force[j]);
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

  void checked_effect(pugi::xml_node at, const char* attribute, const char* effect, Axis axis, double value) {
    if (value < 0.0) xml_.fail(at, text("a ", attribute, " of ", value), "one that is not negative");
    if (axis.coefficients.isZero(0.0)) return;
    if (std::strcmp(effect, "stiffness") != 0) axis.offset = 0.0;
    add_effect(model_, xml_.path(), effect, axis, value);
  }

  // Forces that MuJoCo's joints and fixed tendons share.
  void passive_forces(pugi::xml_node node, const Axis& axis, double rest) {
    checked_effect(node, "damping", "damping", axis, number(node, "damping", 0.0));
    checked_effect(node, "frictionloss", "friction", axis, number(node, "frictionloss", 0.0));
    checked_effect(node, "stiffness", "stiffness", {axis.coefficients, axis.offset - rest}, number(node, "stiffness", 0.0));
  }

  void joint_effects(std::size_t j) {
    const FileJoint& joint = joints_[j];
    passive_forces(joint.node, variables_[j], spring_reference(static_cast<int>(j)));
    checked_effect(joint.node, "armature", "armature", variables_[j], number(joint.node, "armature", 0.0));
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

  void constant_force(int joint, double value) {
    Axis axis = variables_[joint];
    axis.offset = 0.0;
    if (!axis.coefficients.isZero(0.0)) add_effect(model_, xml_.path(), "offset", axis, value);
  }

  XmlFile xml_;
  ModelDescription model_;
  double angle_ = kDegree;
  std::string sequence_ = "xyz";
  bool auto_limits_ = true, geoms_always_ = false, geoms_never_ = false;
  double first_group_ = 0.0, last_group_ = 5.0;
  std::set<std::string> names_;      // of frames
  std::vector<FileJoint> joints_;    // in the order of MuJoCo's qpos
  std::vector<int> joint_of_frame_;  // -1: fixed
  std::vector<Axis> variables_;      // by joint
  std::vector<std::pair<int, double>> biases_;
};

}  // namespace

Model read_mjcf(const std::string& path) {
  return MjcfReader(path).model();
}

}  // namespace veridyn
