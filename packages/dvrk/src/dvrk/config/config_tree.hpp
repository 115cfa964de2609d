#pragma once

#include <set>
#include <string>
#include <vector>

namespace veridyn::dvrk {

/// A configuration file as a tree, equal for XML and JSON: attributes of XML and members of JSON
/// are both members. Repeated elements are consecutive under one name (in JSON: the items of a
/// list).
struct ConfigTree {
  std::string name;     ///< the name in XML; other names in JSON are translated
  std::string written;  ///< the name in the file
  int line = 0;         ///< 0 if unknown (JSON)
  bool scalar = false;  ///< has text and no members
  bool quoted = true;   ///< true for text in JSON, false for a number, true or false
  bool listed = false;  ///< true for an item of a list in JSON
  std::string text;
  std::vector<ConfigTree> members;
};

enum class ConfigFormat { kXml, kJson };

/// @throws InvalidInput  the text is not XML or JSON.
ConfigTree parse_config(const std::string& content, const std::string& file, ConfigFormat format);
/// The tree as text of the format, with a line end.
std::string print_config(const ConfigTree& tree, ConfigFormat format);

/// JSON's name of an XML element ("BoardID": "board_id"), and the inverse; unchanged if they agree.
std::string json_name(const std::string& xml_name);
std::string xml_name(const std::string& json_name);

/// State of reading one file.
struct ConfigSource {
  std::string file;
  ConfigFormat format = ConfigFormat::kXml;
  std::set<const ConfigTree*> used;
};

/// A node with its position in the file. Every getter throws InvalidInput "file:line: place: found ...,
/// expected ...". Names are those of XML; messages contain those of the file.
class ConfigNode {
 public:
  ConfigNode(const ConfigTree& tree, ConfigSource& source, std::string place)
      : tree_(&tree), source_(&source), place_(std::move(place)) {
    source.used.insert(&tree);
  }

  /// Throws InvalidInput with the node's position in the file.
  [[noreturn]] void fail(const std::string& found, const std::string& expected) const;

  bool has(const std::string& name) const { return count(name) > 0; }
  int count(const std::string& name) const;
  /// The member with this name. Throws if there is none, or (without an index) several.
  ConfigNode at(const std::string& name) const;
  /// All members of that name.
  std::vector<ConfigNode> items(const std::string& name) const;

  /// The node's own text.
  std::string word() const;
  double number() const;

  std::string word(const std::string& name) const { return at(name).word(); }
  std::string word(const std::string& name, const std::string& fallback) const;
  double number(const std::string& name) const { return at(name).number(); }
  double number(const std::string& name, double fallback) const;
  /// Numbers above zero, not below zero, other than zero; whole ones from `lower` to `upper`.
  double positive(const std::string& name) const;
  double not_negative(const std::string& name, double fallback) const;
  double nonzero(const std::string& name) const;
  int integer_in(const std::string& name, int lower, int upper) const;
  bool flag(const std::string& name, bool fallback) const;
  /// Index of its text among the words, compared without regard to case.
  int choice(const std::string& name, const std::vector<std::string>& words, int fallback) const;

  /// A nonnegative number, in XML <name Value="1"/>, in JSON "name": 1.
  double value(const std::string& name) const;

 private:
  ConfigNode child_node(const ConfigTree& tree, int index) const;
  std::string display_name(const std::string& name) const;

  const ConfigTree* tree_;
  ConfigSource* source_;
  std::string place_;
};

/// Unused members of the file, one line each.
std::vector<std::string> unused(const ConfigTree& tree, const ConfigSource& source);

}  // namespace veridyn::dvrk
