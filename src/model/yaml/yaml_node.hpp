#pragma once

#include <yaml-cpp/yaml.h>

#include <optional>
#include <string>
#include <vector>

#include "model/expression.hpp"

namespace veridyn {

/// One file while it is read.
struct YamlSource {
  std::string file;
  Constants constants;                          ///< known so far
  std::map<std::string, std::string> formulas;  ///< arithmetic met so far, by place
  std::string expected = "a robot file";        ///< what the file shall be, for messages
};

/// A node that knows where it stands, so that each mistake can be shown. Every getter throws
/// InvalidInput "file:line:column: found ..., expected ...". Keep the source alive while nodes are
/// used.
class YamlNode {
 public:
  struct Entry;

  /// @throws InvalidInput  the text is not YAML.
  static YamlNode parse(const std::string& content, YamlSource& source);

  [[noreturn]] void fail(const std::string& found, const std::string& expected) const;
  /// What stands here, for messages.
  std::string found() const;
  /// "file:line".
  std::string where() const;

  bool is_map() const { return node_.IsMap(); }
  bool is_list() const { return node_.IsSequence(); }

  std::string word(const std::string& expected) const;
  double number() const;
  double positive_number() const;
  double number_or_infinity() const;
  bool flag() const;

  /// A list of exactly `size` numbers; `expected` says which.
  std::vector<double> numbers(std::size_t size, const std::string& expected) const;
  std::vector<YamlNode> items(const std::string& expected) const;
  /// Entries of a map in the order of the file, keys unique.
  std::vector<Entry> entries(const std::string& expected) const;

  /// Fails unless this is a map all of whose keys are among those given.
  void allow_keys(const std::vector<std::string>& keys) const;
  std::optional<YamlNode> find(const std::string& key) const;
  YamlNode at(const std::string& key) const;

  /// The same node under another place, for formulas: "frames/elbow" rather than "frames/4".
  YamlNode placed(const std::string& place) const;

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
