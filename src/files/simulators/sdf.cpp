#include "veridyn/files/sdf.hpp"

#include <cstring>
#include <pugixml.hpp>

#include "veridyn/math/require.hpp"
#include "veridyn/files/urdf.hpp"
#include "xml.hpp"

namespace veridyn {
namespace {

// SDF gives a link without an inertial a mass of 1 kg, so that one with tiny values is written.
constexpr double kLeastSdfMass = 1e-9;      // [kg]
constexpr double kNoInertia = 1e-12;  // [kg m^2]

void add_element(pugi::xml_node above, const char* name, const std::string& content) {
  above.append_child(name).text().set(content.c_str());
}

std::string given(pugi::xml_node node, const char* name, const char* otherwise) {
  const pugi::xml_attribute attribute = node.attribute(name);
  return attribute ? attribute.value() : otherwise;
}

// Text "x y z r p y" of URDF's <origin>.
std::string pose_of(pugi::xml_node node) {
  const pugi::xml_node origin = node.child("origin");
  return given(origin, "xyz", "0 0 0") + " " + given(origin, "rpy", "0 0 0");
}

// Translates the tree from URDF's elements to SDF's.
class SdfWriter {
 public:
  SdfWriter(const Model& arm, const UrdfExtras& extras) {
    const std::string urdf = to_urdf(arm, extras);
    const pugi::xml_parse_result parsed =
        urdf_.load_buffer(urdf.data(), urdf.size(), pugi::parse_default | pugi::parse_comments);
    require(bool(parsed), "export: the URDF of '", arm.name(), "' is no XML: ",
            parsed.description());
  }

  std::string xml() {
    const pugi::xml_node robot = urdf_.child("robot");
    const bool mimics = !robot.select_node("joint/mimic").node().empty();
    pugi::xml_node root = sdf_.append_child("sdf");
    set(root, "version", mimics ? "1.11" : "1.7");
    model_ = root.append_child("model");
    set(model_, "name", robot.attribute("name").value());
    for (const pugi::xml_node node : robot.children()) {
      if (node.type() == pugi::node_comment) add_comment(model_, trimmed(node.value()));
    }
    for (const pugi::xml_node node : robot.children("link")) add_link(node);
    for (const pugi::xml_node node : robot.children("joint")) add_joint(node);
    return xml_text(sdf_);
  }

 private:
  static std::string trimmed(const std::string& words) {
    const std::size_t first = words.find_first_not_of(' ');
    if (first == std::string::npos) return {};
    return words.substr(first, words.find_last_not_of(' ') + 1 - first);
  }

  // All parts of a model share one name space in SDFormat.
  std::string link_name(const std::string& name) const {
    const pugi::xml_node robot = urdf_.child("robot");
    if (!robot.find_child_by_attribute("joint", "name", name.c_str())) return name;
    std::string own = name;
    do own += "_link";
    while (robot.find_child_by_attribute("joint", "name", own.c_str()) || robot.find_child_by_attribute("link", "name", own.c_str()));
    return own;
  }

  void add_link(pugi::xml_node from) {
    const std::string name = from.attribute("name").value();
    if (name == "world") return;
    pugi::xml_node to = model_.append_child("link");
    set(to, "name", link_name(name));
    const pugi::xml_node above = joint_above(name);
    if (above) {
      pugi::xml_node pose = to.append_child("pose");
      set(pose, "relative_to", above.attribute("name").value());
      pose.text().set("0 0 0 0 0 0");
    }
    for (const pugi::xml_node node : from.children()) {
      if (node.type() == pugi::node_comment) add_comment(to, trimmed(node.value()));
    }
    add_inertial(from.child("inertial"), to.append_child("inertial"));
    int count = 0;
    for (const char* kind : {"visual", "collision"}) {
      for (const pugi::xml_node shape : from.children(kind)) {
        pugi::xml_node out = to.append_child(kind);
        set(out, "name", name + "_" + kind + "_" + std::to_string(++count));
        add_element(out, "pose", pose_of(shape));
        add_geometry(shape.child("geometry"), out.append_child("geometry"));
      }
    }
  }

  static void add_inertial(pugi::xml_node from, pugi::xml_node to) {
    const bool none = from.empty();
    if (!none) add_element(to, "pose", pose_of(from));
    add_element(to, "mass",
            none ? xml_number(kLeastSdfMass) : given(from.child("mass"), "value", "0"));
    pugi::xml_node inertia = to.append_child("inertia");
    for (const char* key : {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"}) {
      const bool diagonal = key[1] == key[2];
      add_element(inertia, key,
              none ? xml_number(diagonal ? kNoInertia : 0.0)
                   : given(from.child("inertia"), key, "0"));
    }
  }

  static void add_geometry(pugi::xml_node from, pugi::xml_node to) {
    for (const pugi::xml_node shape : from.children()) {
      pugi::xml_node out = to.append_child(shape.name());
      for (const pugi::xml_attribute attribute : shape.attributes()) {
        const bool file = std::strcmp(attribute.name(), "filename") == 0;
        add_element(out, file ? "uri" : attribute.name(), attribute.value());
      }
    }
  }

  pugi::xml_node joint_above(const std::string& link) const {
    return urdf_.child("robot").find_child([&](const pugi::xml_node& node) {
      return std::strcmp(node.name(), "joint") == 0 &&
             link == node.child("child").attribute("link").value();
    });
  }

  void add_joint(pugi::xml_node from) {
    pugi::xml_node to = model_.append_child("joint");
    const std::string type = from.attribute("type").value();
    set(to, "name", from.attribute("name").value());
    set(to, "type", type);
    const std::string parent = from.child("parent").attribute("link").value();
    pugi::xml_node pose = to.append_child("pose");
    set(pose, "relative_to", parent == "world" ? "__model__" : link_name(parent));
    pose.text().set(pose_of(from).c_str());
    add_element(to, "parent", link_name(parent));
    add_element(to, "child", link_name(from.child("child").attribute("link").value()));
    if (type == "fixed") return;
    pugi::xml_node axis = to.append_child("axis");
    add_element(axis, "xyz", given(from.child("axis"), "xyz", "1 0 0"));
    const pugi::xml_node limit = from.child("limit");
    pugi::xml_node limits = axis.append_child("limit");
    const bool turns_freely = type == "continuous" || limit.empty();
    add_element(limits, "lower", turns_freely ? "-1e16" : given(limit, "lower", "-1e16"));
    add_element(limits, "upper", turns_freely ? "1e16" : given(limit, "upper", "1e16"));
    if (limit) {
      add_element(limits, "effort", given(limit, "effort", "-1"));
      add_element(limits, "velocity", given(limit, "velocity", "-1"));
    }
    if (const pugi::xml_node dynamics = from.child("dynamics")) {
      pugi::xml_node out = axis.append_child("dynamics");
      add_element(out, "damping", given(dynamics, "damping", "0"));
      add_element(out, "friction", given(dynamics, "friction", "0"));
    }
    if (const pugi::xml_node mimic = from.child("mimic")) {
      pugi::xml_node out = axis.append_child("mimic");
      set(out, "joint", mimic.attribute("joint").value());
      add_element(out, "multiplier", given(mimic, "multiplier", "1"));
      add_element(out, "offset", given(mimic, "offset", "0"));
      add_element(out, "reference", "0");
    }
  }

  pugi::xml_document urdf_, sdf_;
  pugi::xml_node model_;
};

}  // namespace

std::string to_sdf(const Model& arm, const UrdfExtras& extras) {
  require(arm.inertial_values().has_value(), "export: arm '", arm.name(),
          "' has bodies without values, expected a MODEL that identify or diagnose wrote.");
  return SdfWriter(arm, extras).xml();
}

}  // namespace veridyn
