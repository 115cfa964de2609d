#pragma once

#include <yaml-cpp/yaml.h>

#include <optional>
#include <string>
#include <vector>

#include "veridyn/files/expression.hpp"

namespace veridyn {

/// Data that accumulate while one file is read.
struct YamlSource {
  std::string file;
  Constants constants;                          ///< constants read so far
  std::map<std::string, std::string> formulas;  ///< expressions read so far, by path
  std::string expected = "a robot file";        ///< kind of file, for messages
};

/// A node with its position in the file, for messages. Every getter throws InvalidInput
/// "file:line:column: found ..., expected ...". The source must outlive its nodes.
class YamlNode {
 public:
  struct Entry;

  /// @throws InvalidInput  the text is not YAML.
  static YamlNode parse(const std::string& content, YamlSource& source);

  [[noreturn]] void fail(const std::string& found, const std::string& expected) const;
  /// Content of the node, for messages.
  std::string found() const;
  /// Position of the node as "file:line".
  std::string where() const;

  bool is_map() const { return node_.IsMap(); }
  bool is_list() const { return node_.IsSequence(); }

  std::string word(const std::string& expected) const;
  double number() const;
  double positive_number() const;
  double number_or_infinity() const;
  bool flag() const;

  /// A list of exactly `size` numbers; `expected` describes them in messages.
  std::vector<double> numbers(std::size_t size, const std::string& expected) const;
  std::vector<YamlNode> items(const std::string& expected) const;
  /// Entries of a map in the order of the file, keys unique.
  std::vector<Entry> entries(const std::string& expected) const;

  /// Throws unless this is a map with no other keys than these.
  void allow_keys(const std::vector<std::string>& keys) const;
  std::optional<YamlNode> find(const std::string& key) const;
  YamlNode at(const std::string& key) const;

  /// This node under another path, for expressions: "frames/elbow" rather than "frames/4".
  YamlNode with_path(const std::string& place) const;

 private:
  YamlNode(YAML::Node node, YamlSource& source, std::string place)
      : node_(std::move(node)), source_(&source), place_(std::move(place)) {}

  YAML::Node node_;
  YamlSource* source_;
  std::string place_;
};

struct YamlNode::Entry {
  std::string key;
  YamlNode key_node;
  YamlNode value;
};

}  // namespace veridyn
