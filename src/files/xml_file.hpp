#pragma once

#include <pugixml.hpp>
#include <string>
#include <vector>

namespace veridyn {

/// An XML document together with its text, so that messages name file, line and column.
class XmlFile {
 public:
  /// @param expected  description of the file for messages: "an MJCF file".
  /// @throws InvalidInput  no such file, no XML, elements nested deeper than 500, or another root element.
  XmlFile(std::string path, const char* root, const std::string& expected);

  const std::string& path() const { return path_; }
  pugi::xml_node root() const { return document_.document_element(); }

  /// @throws InvalidInput  "file:line:column: found ..., expected ...".
  [[noreturn]] void fail(pugi::xml_node at, const std::string& found, const std::string& expected) const;

  /// Line of an element, from 1.
  long line(pugi::xml_node at) const;

  /// Numbers separated by white space. @throws InvalidInput  non-finite or no numbers, or a count
  /// outside of least ... most. @param name  what the message calls them.
  std::vector<double> numbers(pugi::xml_node at, const std::string& name, const std::string& words, int least,
                              int most) const;

  /// One number, which may be infinite.
  double number(pugi::xml_node at, const std::string& name, const std::string& words) const;

 private:
  std::string path_;
  std::string text_;
  pugi::xml_document document_;
};

/// The name of the root element of an XML file, or empty where it has none.
std::string root_element(const std::string& path);

}  // namespace veridyn
