#include "veridyn/math/require.hpp"
#include "math/eigen_pose.hpp"
#include "model/excerpt.hpp"
#include "math/numbers.hpp"
#include "veridyn/files/urdf.hpp"

#ifdef VERIDYN_WITH_URDF

#include <console_bridge/console.h>
#include <tinyxml.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>

#include "files/input_file.hpp"
#include "model/joint_placement.hpp"
#include "effects/effect_names.hpp"
#include "files/urdf/urdf_check.hpp"

namespace veridyn {
namespace {

constexpr double kUnlimited =
    1e9;  // value of to_urdf() where URDF requires a number and the model has none

constexpr int kDeepestXml = 100;  // a URDF has five; TinyXML recurses once for each

// The nesting depth of the elements, found without recursion. Comments, declarations and quoted
// values hold no tags.
int depth_of_xml(const std::string& content) {
  int depth = 0, deepest = 0;
  for (std::size_t at = content.find('<'); at != std::string::npos; at = content.find('<', at)) {
    if (content.compare(at, 4, "<!--") == 0 || content.compare(at, 9, "<![CDATA[") == 0) {
      at = content.find(content[at + 2] == '-' ? "-->" : "]]>", at);
      continue;
    }
    const bool closes = content.compare(at, 2, "</") == 0;
    const bool declares = content.compare(at, 2, "<?") == 0 || content.compare(at, 2, "<!") == 0;
    char quote = 0;
    while (++at < content.size() && (quote != 0 || content[at] != '>')) {
      const char c = content[at];
      if (quote == 0 && !declares && (c == '"' || c == '\'')) quote = c;
      else if (c == quote) quote = 0;
    }
    if (declares || at >= content.size()) continue;
    if (closes) --depth;
    else if (content[at - 1] != '/') deepest = std::max(deepest, ++depth);
  }
  return deepest;
}

// Collects the messages of urdfdom's parser, which otherwise go to the console.
class ParserLog : public console_bridge::OutputHandler {
 public:
  ParserLog() { console_bridge::useOutputHandler(this); }
  ~ParserLog() override { console_bridge::restorePreviousOutputHandler(); }
  ParserLog(const ParserLog&) = delete;
  ParserLog& operator=(const ParserLog&) = delete;
  void log(const std::string& message, console_bridge::LogLevel level, const char* /*file*/,
           int /*line*/) override {
    if (level == console_bridge::CONSOLE_BRIDGE_LOG_ERROR && first_error.empty())
      first_error = message;
  }
  std::string first_error;
};

std::string one_line(std::string message) {
  for (char& c : message) {
    if (c == '\n' || c == '\r') c = ' ';
  }
  return message;
}

Vec3d vector(const urdf::Vector3& v) {
  return {v.x, v.y, v.z};
}

Mat3d rotation(const urdf::Rotation& r) {
  const auto clean = [](double v) {
    return std::abs(v) < std::numeric_limits<double>::epsilon() ? 0.0 : v;
  };
  const double xx = r.x * r.x, yy = r.y * r.y, zz = r.z * r.z;
  const double xy = r.x * r.y, xz = r.x * r.z, yz = r.y * r.z;
  const double wx = r.w * r.x, wy = r.w * r.y, wz = r.w * r.z;
  // clang-format off
  return {{clean(1 - 2 * (yy + zz)), clean(2 * (xy - wz)),     clean(2 * (xz + wy))},
          {clean(2 * (xy + wz)),     clean(1 - 2 * (xx + zz)), clean(2 * (yz - wx))},
          {clean(2 * (xz - wy)),     clean(2 * (yz + wx)),     clean(1 - 2 * (xx + yy))}};
  // clang-format on
}

bool is_finite(const Vec3d& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

class UrdfReader {
 public:
  UrdfReader(std::string file, const std::string& content) : file_(std::move(file)) {
    if (const int depth = depth_of_xml(content); depth > kDeepestXml) {
      fail("", text("elements ", depth, " deep"), text("at most ", kDeepestXml));
    }
    xml_.Parse(content.c_str());
    if (xml_.Error()) {
      fail(text(xml_.ErrorRow(), ":", xml_.ErrorCol(), ":"),
           text("text that is not XML (", xml_.ErrorDesc(), ")"), "a URDF file");
    }
    check_urdf(file_, xml_);
    parse(content);
  }

  Model model() {
    model_.name = urdf_->getName();
    model_.source = file_;
    model_.values = RobotValues::kPrior;
    read_coordinates();
    const urdf::LinkConstSharedPtr root = urdf_->getRoot();
    if (root->name != "world") add_root(*root);
    const TiXmlElement* element = xml_.RootElement()->FirstChildElement("link");
    for (; element != nullptr; element = element->NextSiblingElement("link")) {
      const urdf::LinkConstSharedPtr link = urdf_->getLink(element->Attribute("name"));
      if (link->parent_joint) add_link_of(*link->parent_joint);
    }
    give_bodies_without_values();
    return Model(model_);
  }

 private:
  [[noreturn]] void fail(const std::string& place, const std::string& found,
                         const std::string& expected) const {
    throw InvalidInput(text(file_, ":", place, " found ", excerpt(found, 400), ", expected ", expected, "."));
  }

  [[noreturn]] void fail_at(const std::string& tag, const std::string& name,
                            const std::string& found, const std::string& expected) const {
    const TiXmlElement* element = xml_.RootElement()->FirstChildElement(tag);
    while (element != nullptr &&
           name != text(element->Attribute("name") ? element->Attribute("name") : "")) {
      element = element->NextSiblingElement(tag);
    }
    const std::string place =
        element == nullptr ? "" : text(element->Row(), ":", element->Column(), ":");
    fail(place, tag + " '" + name + "' with " + found, expected);
  }

  void parse(const std::string& content) {
    static std::mutex one_at_a_time;  // the log handler is global
    const std::lock_guard<std::mutex> lock(one_at_a_time);
    ParserLog log;
    try {
      urdf_ = urdf::parseURDF(content);
    } catch (const std::exception& error) {
      log.first_error = error.what();
    }
    // urdfdom drops elements that it cannot read and continues; a body that is silently missing is
    // worse than an error.
    if (!urdf_ || !log.first_error.empty()) {
      fail("", "no valid URDF (" + one_line(log.first_error) + ")", "a URDF file");
    }
  }

  // Reads coordinates in the order of the file, which urdfdom does not keep: it is the column order
  // of recordings.
  void read_coordinates() {
    const TiXmlElement* element = xml_.RootElement()->FirstChildElement("joint");
    for (; element != nullptr; element = element->NextSiblingElement("joint")) {
      const urdf::JointConstSharedPtr joint = urdf_->getJoint(element->Attribute("name"));
      if (moves(*joint) && !joint->mimic) model_.coordinates.push_back(coordinate(*joint));
    }
    if (model_.coordinates.empty()) fail("", "no joint that moves", "at least one");
    if (model_.coordinates.size() > kMostCoordinates)
      fail("", text(model_.coordinates.size(), " joints that move"), text("at most ", kMostCoordinates));
  }

  static bool moves(const urdf::Joint& joint) { return joint.type != urdf::Joint::FIXED; }

  Coordinate coordinate(const urdf::Joint& joint) const {
    Coordinate c;
    c.name = joint.name;
    c.limits = {-kInfinity, kInfinity, kInfinity, kInfinity, kInfinity};
    if (!joint.limits) return c;
    const urdf::JointLimits& given = *joint.limits;
    const bool ranged =
        joint.type != urdf::Joint::CONTINUOUS && (given.lower != 0.0 || given.upper != 0.0);
    if (ranged && !(given.lower < given.upper)) {
      fail_at("joint", joint.name, text("limits [", given.lower, ", ", given.upper, "]"),
              "lower < upper");
    }
    if (ranged && given.lower > -kUnlimited) c.limits.lower = given.lower;
    if (ranged && given.upper < kUnlimited) c.limits.upper = given.upper;
    if (given.velocity > 0.0 && given.velocity < kUnlimited) c.limits.velocity = given.velocity;
    if (given.effort > 0.0 && given.effort < kUnlimited) c.limits.effort = given.effort;
    return c;
  }

  // s = c . q + s0 of a joint; that of a mimic joint follows from the joint that it mimics.
  Axis variable(const urdf::Joint& joint, std::size_t depth) const {
    Axis axis{VectorXd::Zero(model_.coordinates.size()), 0.0};
    if (!moves(joint)) return axis;
    if (!joint.mimic) {
      for (std::size_t i = 0; i < model_.coordinates.size(); ++i) {
        if (model_.coordinates[i].name == joint.name)
          axis.coefficients[static_cast<Eigen::Index>(i)] = 1.0;
      }
      return axis;
    }
    const urdf::JointConstSharedPtr leader = urdf_->getJoint(joint.mimic->joint_name);
    if (!leader) {
      fail_at("joint", joint.name, "mimic of the unknown joint '" + joint.mimic->joint_name + "'",
              "a joint");
    }
    if (depth > urdf_->joints_.size()) {
      fail_at("joint", joint.name, "mimics in a cycle", "a joint that mimics none in the end");
    }
    axis = variable(*leader, depth + 1);
    axis.coefficients *= joint.mimic->multiplier;
    axis.offset = axis.offset * joint.mimic->multiplier + joint.mimic->offset;
    return axis;
  }

  // A file without any inertial describes the kinematics alone: each link that a joint moves has a body then.
  void give_bodies_without_values() {
    for (const Frame& frame : model_.frames) {
      if (frame.body) return;
    }
    for (Frame& frame : model_.frames) {
      if (frame.type != JointType::kFixed) frame.body = Body{};
    }
  }

  void add_root(const urdf::Link& link) {
    Frame frame;
    frame.name = link.name;
    frame.body = body(link);
    model_.frames.push_back(std::move(frame));
  }

  std::optional<FrameIndex> find_frame(const std::string& name) const {
    for (std::size_t k = 0; k < model_.frames.size(); ++k) {
      if (model_.frames[k].name == name) return FrameIndex{static_cast<int>(k)};
    }
    return std::nullopt;
  }

  // Adds the child link of a joint, after the links above it.
  void add_link_of(const urdf::Joint& joint) {
    if (find_frame(joint.child_link_name)) return;
    const urdf::LinkConstSharedPtr parent = urdf_->getLink(joint.parent_link_name);
    if (parent->parent_joint) add_link_of(*parent->parent_joint);
    Frame frame;
    frame.name = joint.child_link_name;
    frame.parent = find_frame(joint.parent_link_name);
    frame.type = !moves(joint)                          ? JointType::kFixed
                 : joint.type == urdf::Joint::PRISMATIC ? JointType::kPrismatic
                                                        : JointType::kRevolute;
    frame.variable = variable(joint, 0);
    place(frame, placement(joint));
    frame.body = body(*urdf_->getLink(joint.child_link_name));
    add_friction(joint, frame.variable);
    model_.frames.push_back(std::move(frame));
  }

  JointPlacement placement(const urdf::Joint& joint) const {
    const urdf::Pose& pose = joint.parent_to_joint_origin_transform;
    JointPlacement placement{
        {rotation(pose.rotation), vector(pose.position)}, {0, 0, 1}, {0, 0, 0}};
    const Mat3d& R = placement.origin.R;
    if (!is_finite(placement.origin.p) || !is_finite(R.row0) || !is_finite(R.row1) ||
        !is_finite(R.row2)) {
      fail_at("joint", joint.name, "an origin that is not finite", "finite numbers");
    }
    if (!moves(joint)) return placement;
    const Vec3d axis = vector(joint.axis);
    const double length = std::sqrt(dot(axis, axis));
    placement.axis = {axis.x / length, axis.y / length, axis.z / length};
    return placement;
  }

  std::optional<Body> body(const urdf::Link& link) const {
    if (!link.inertial) return std::nullopt;
    const urdf::Inertial& given = *link.inertial;
    const Eigen::Matrix3d R = eigen(rotation(given.origin.rotation));
    Eigen::Matrix3d I;
    I << given.ixx, given.ixy, given.ixz, given.ixy, given.iyy, given.iyz, given.ixz, given.iyz,
        given.izz;
    I = (R * I * R.transpose()).eval();
    Eigen::Matrix<double, 6, 1> inertia;
    inertia << I(0, 0), I(0, 1), I(1, 1), I(0, 2), I(1, 2), I(2, 2);
    const Eigen::Vector3d com(given.origin.position.x, given.origin.position.y,
                              given.origin.position.z);
    Body body;
    body.phi = inertial_parameters(given.mass, com, inertia);
    if (!body.phi->allFinite())
      fail_at("link", link.name, "an inertial that is not finite", "finite numbers");
    if (given.mass < 0.0)
      fail_at("link", link.name, text("a mass of ", given.mass, " kg"), "one that is not negative");
    return body;
  }

  void add_friction(const urdf::Joint& joint, const Axis& axis) {
    if (!joint.dynamics || !moves(joint)) return;
    const auto add = [&](const char* attribute, double value) {
      if (value == 0.0) return;
      if (!(value > 0.0)) {
        fail_at("joint", joint.name, text("a ", attribute, " of ", value), "one that is not negative");
      }
      const auto [effect, key] = effect_of_attribute(attribute).value();
      EffectTerm term;
      term.effect = effect;
      term.axis.coefficients = axis.coefficients;
      term.values[key] = value;
      term.where = file_;
      model_.effects.push_back(std::move(term));
    };
    add("damping", joint.dynamics->damping);
    add("friction", joint.dynamics->friction);
  }

  std::string file_;
  TiXmlDocument xml_;
  urdf::ModelInterfaceSharedPtr urdf_;
  ModelDescription model_;
};

}  // namespace

Model read_urdf(const std::string& path) {
  return UrdfReader(path, content_of_file(path, "a URDF file")).model();
}

}  // namespace veridyn

#else

namespace veridyn {

Model read_urdf(const std::string& path) {
  throw InvalidInput(
      path +
      ": found a URDF file, expected YAML: veridyn was built without urdfdom (VERIDYN_URDF).");
}

}  // namespace veridyn

#endif
