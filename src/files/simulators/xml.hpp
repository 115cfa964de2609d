#pragma once

#include <pugixml.hpp>
#include <string>

#include "veridyn/math/types.hpp"
#include "veridyn/math/vector3.hpp"

namespace veridyn {

// Small helpers for writers of XML.

/// The shortest digits that are read back as the same number; no negative zero.
std::string xml_number(double value);

/// Text "x y z".
std::string xml_vector(const Vec3d& v);
std::string xml_vector(const Eigen::Vector3d& v);

/// Sets an attribute.
void set(pugi::xml_node node, const char* name, const std::string& value);
void set(pugi::xml_node node, const char* name, double value);

/// Text of a comment, between blanks; two hyphens in a row, which XML forbids there, are separated.
std::string comment_words(std::string words);
void add_comment(pugi::xml_node node, const std::string& words);

/// The document as text, indented by two.
std::string xml_text(const pugi::xml_document& document);

}  // namespace veridyn
