#include <pugixml.hpp>

#include "veridyn/math/require.hpp"
#include "veridyn/math/text_stream.hpp"
#include "veridyn/files/urdf.hpp"

namespace veridyn {
namespace {

std::string printed(const pugi::xml_node& node) {
  TextStream out;
  node.print(out, "  ", pugi::format_indent, pugi::encoding_utf8, 0);
  return out.str();
}

}  // namespace

UrdfAppearance urdf_appearance(const std::string& path) {
  pugi::xml_document document;
  const pugi::xml_parse_result parsed = document.load_file(path.c_str());
  require(bool(parsed), path, ": found no XML (", parsed.description(), "), expected a URDF file.");
  UrdfAppearance out;
  const pugi::xml_node robot = document.child("robot");
  for (const pugi::xml_node material : robot.children("material")) out[""] += printed(material);
  for (const pugi::xml_node link : robot.children("link")) {
    for (const char* kind : {"visual", "collision"}) {
      for (const pugi::xml_node shape : link.children(kind))
        out[link.attribute("name").value()] += printed(shape);
    }
  }
  return out;
}

}  // namespace veridyn
