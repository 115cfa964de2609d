#include "xml.hpp"

#include <fmt/format.h>

#include "math/eigen_pose.hpp"
#include "veridyn/math/text_stream.hpp"

namespace veridyn {

std::string xml_number(double value) {
  return fmt::format("{}", value + 0.0);
}

std::string xml_vector(const Vec3d& v) {
  return xml_number(v.x) + " " + xml_number(v.y) + " " + xml_number(v.z);
}

std::string xml_vector(const Eigen::Vector3d& v) {
  return xml_vector(from_eigen(v));
}

void set(pugi::xml_node node, const char* name, const std::string& value) {
  node.append_attribute(name).set_value(value.c_str());
}

void set(pugi::xml_node node, const char* name, double value) {
  set(node, name, xml_number(value));
}

std::string comment_words(std::string words) {
  for (std::size_t at = words.find("--"); at != std::string::npos; at = words.find("--")) words.replace(at, 2, "- ");
  return " " + words + " ";
}

void add_comment(pugi::xml_node node, const std::string& words) {
  node.append_child(pugi::node_comment).set_value(comment_words(words).c_str());
}

std::string xml_text(const pugi::xml_document& document) {
  TextStream out;
  document.save(out, "  ", pugi::format_default, pugi::encoding_utf8);
  return out.str();
}

}  // namespace veridyn
