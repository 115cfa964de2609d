#include "files/urdf/urdf_check.hpp"

#ifdef VERIDYN_WITH_URDF

#include <tinyxml.h>

#include <cmath>
#include <map>
#include <sstream>
#include <vector>

#include "model/excerpt.hpp"
#include "math/numbers.hpp"
#include "files/words.hpp"
#include "model/suggestion.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

using Element = const TiXmlElement*;

std::string attribute(Element element, const char* name) {
  const char* words = element == nullptr ? nullptr : element->Attribute(name);
  return words == nullptr ? "" : words;
}

class UrdfCheck {
 public:
  UrdfCheck(const std::string& file, Element root) : file_(file), root_(root) {}

  void run() {
    for (Element e = root_; e != nullptr; e = next(e)) no_xacro(e);
    for (Element e = first("link"); e != nullptr; e = e->NextSiblingElement("link")) link(e);
    for (Element e = first("joint"); e != nullptr; e = e->NextSiblingElement("joint")) joint(e);
    one_root();
  }

 private:
  Element first(const char* tag) const { return root_->FirstChildElement(tag); }

  // The next element of the whole document, without recursion.
  static Element next(Element e) {
    if (Element child = e->FirstChildElement()) return child;
    const TiXmlNode* at = e;
    while (at != nullptr && at->NextSiblingElement() == nullptr) at = at->Parent();
    return at == nullptr ? nullptr : at->NextSiblingElement();
  }

  [[noreturn]] void fail(Element at, const std::string& found, const std::string& expected) const {
    throw InvalidInput(text(file_, ":", at->Row(), ":", at->Column(), ": found ", excerpt(found, 400), ", expected ", expected, "."));
  }

  void no_xacro(Element e) const {
    const auto refuse = [&](const std::string& words) {
      fail(e, "xacro that was not expanded, '" + words + "'",
           "a URDF: `xacro " + file_ + " > arm.urdf` writes it (`ros2 run xacro xacro` in ROS 2)");
    };
    if (e->ValueStr().rfind("xacro:", 0) == 0) refuse("<" + e->ValueStr() + ">");
    const bool described = e->ValueStr() != "plugin";
    for (const TiXmlAttribute* a = e->FirstAttribute(); a != nullptr && described; a = a->Next())
      if (a->ValueStr().find("${") != std::string::npos || a->ValueStr().find("$(") != std::string::npos) refuse(a->ValueStr());
  }

  // Finite numbers, where the attribute is there.
  std::vector<double> numbers(Element at, const std::string& whose, Element of, const char* name, size_t count) const {
    std::vector<double> out;
    if (of == nullptr || of->Attribute(name) == nullptr) return out;
    const std::string words = attribute(of, name);
    std::istringstream in(words);
    for (std::string word; in >> word;) {
      const std::optional<double> value = number_in(word);
      const bool comma = word.find(',') != std::string::npos;
      if (!value || !std::isfinite(*value)) {
        fail(at, text(whose, " with ", of->ValueStr(), " ", name, "=\"", words, "\""),
             text(count, count == 1 ? " finite number" : " finite numbers with spaces between", comma ? " and a point in them, not a comma" : ""));
      }
      out.push_back(*value);
    }
    if (out.size() != count)
      fail(at, text(whose, " with ", of->ValueStr(), " ", name, "=\"", words, "\""), text(count, count == 1 ? " number" : " numbers"));
    return out;
  }

  // The name of a joint or link, once in the file.
  std::string name_of(Element e, std::map<std::string, Element>& known) const {
    const std::string tag = e->ValueStr();
    const std::string name = attribute(e, "name");
    if (name.empty()) fail(e, "a " + tag + " without a name", "<" + tag + " name=\"...\">");
    if (const auto there = known.find(name); there != known.end())
      fail(e, text("the second ", tag, " '", name, "', after line ", there->second->Row()), "another name for one of them");
    known[name] = e;
    return name;
  }

  void link(Element e) {
    const std::string whose = "link '" + name_of(e, links_) + "'";
    Element inertial = e->FirstChildElement("inertial");
    if (inertial == nullptr) return;
    pose(inertial, whose, inertial->FirstChildElement("origin"));
    Element mass = inertial->FirstChildElement("mass"), inertia = inertial->FirstChildElement("inertia");
    if (numbers(inertial, whose, mass, "value", 1).empty()) fail(inertial, whose + " with an inertial without a mass", "<mass value=\"KG\"/>");
    for (const char* key : {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"}) {
      if (numbers(inertial, whose, inertia, key, 1).empty())
        fail(inertial, whose + " with an inertia without " + key, "<inertia ixx=\"\" ixy=\"\" ixz=\"\" iyy=\"\" iyz=\"\" izz=\"\"/> [kg m^2]");
    }
  }

  void pose(Element at, const std::string& whose, Element origin) const {
    for (const char* key : {"xyz", "rpy"}) numbers(at, whose, origin, key, 3);
  }

  std::string linked(Element e, const std::string& whose, const char* end) const {
    const std::string name = attribute(e->FirstChildElement(end), "link");
    if (name.empty()) fail(e, whose + " without its " + end, text("<", end, " link=\"...\"/>"));
    if (links_.count(name) == 0) {
      std::vector<std::string> known;
      for (const auto& [link, at] : links_) known.push_back(link);
      fail(e, text(whose, " with the ", end, " '", name, "', which is no link"), "the name of a link" + did_you_mean(name, known));
    }
    return name;
  }

  void joint(Element e) {
    const std::string whose = "joint '" + name_of(e, joints_) + "'";
    const std::string type = attribute(e, "type");
    if (type == "floating" || type == "planar")
      fail(e, whose + " with a " + type + " type", "revolute, continuous, prismatic or fixed; type=\"fixed\" where the base stands still");
    const bool ranged = type == "revolute" || type == "prismatic";
    if (!ranged && type != "continuous" && type != "fixed")
      fail(e, whose + " with the type '" + type + "'", "revolute, continuous, prismatic or fixed");
    const std::string parent = linked(e, whose, "parent"), child = linked(e, whose, "child");
    if (const auto there = parents_.find(child); there != parents_.end())
      fail(e, text(whose, " with the child '", child, "', which joint '", attribute(there->second, "name"), "' carries (line ", there->second->Row(), ")"),
           "one joint above each link");
    parents_[child] = e;
    above_[child] = parent;
    pose(e, whose, e->FirstChildElement("origin"));
    const std::vector<double> axis = numbers(e, whose, e->FirstChildElement("axis"), "xyz", 3);
    const bool moves = type != "fixed";
    if (moves && !axis.empty() && axis[0] == 0.0 && axis[1] == 0.0 && axis[2] == 0.0)
      fail(e, whose + " with no direction of its axis", "one, as <axis xyz=\"0 0 1\"/>");
    Element limit = e->FirstChildElement("limit");
    const std::string limits = "<limit lower=\"\" upper=\"\" velocity=\"\" effort=\"\"/>, 0 for a velocity or an effort that is not known";
    if (ranged && limit == nullptr) fail(e, whose + " of type " + type + " without limits", limits);
    for (const char* key : {"lower", "upper", "velocity", "effort"}) {
      const bool needed = key[0] == 'v' || key[0] == 'e';
      if (numbers(e, whose, limit, key, 1).empty() && needed && limit != nullptr) fail(e, whose + " with a limit without " + key, limits);
    }
    for (const char* key : {"damping", "friction"}) numbers(e, whose, e->FirstChildElement("dynamics"), key, 1);
    for (const char* key : {"multiplier", "offset"}) numbers(e, whose, e->FirstChildElement("mimic"), key, 1);
  }

  void one_root() const {
    if (links_.empty()) fail(root_, "no links", "<link name=\"...\">");
    std::vector<std::string> roots;
    for (Element e = first("link"); e != nullptr; e = e->NextSiblingElement("link"))
      if (parents_.count(attribute(e, "name")) == 0) roots.push_back(attribute(e, "name"));
    if (roots.empty()) {
      Element e = first("joint");
      fail(e, "a joint above every link ('" + attribute(e, "name") + "' among them)", "a tree: one link without a joint above it");
    }
    if (roots.size() > 1) {
      fail(links_.at(roots[1]), text(roots.size(), " links without a joint above them: ", listed(roots)),
           "one: a joint of type fixed carries link '" + roots[1] + "', or the link is deleted");
    }
    for (const auto& [child, e] : parents_) {
      std::string at = child;
      for (size_t k = 0; above_.count(at) > 0 && k <= parents_.size(); ++k) at = above_.at(at);
      if (above_.count(at) > 0) fail(e, "joint '" + attribute(e, "name") + "' with a link below itself", "a tree of links");
    }
  }

  const std::string& file_;
  Element root_;
  std::map<std::string, Element> links_, joints_;
  std::map<std::string, Element> parents_;    // joint above a link
  std::map<std::string, std::string> above_;  // link above a link
};

}  // namespace

void check_urdf(const std::string& file, const TiXmlDocument& xml) {
  const TiXmlElement* root = xml.RootElement();
  require(root != nullptr && root->ValueStr() == "robot", file, ": found ",
          root == nullptr ? std::string("no element") : "the root element '" + excerpt(root->ValueStr()) + "'",
          ", expected a URDF file, which begins with <robot name=\"...\">.");
  UrdfCheck(file, root).run();
}

}  // namespace veridyn

#endif
