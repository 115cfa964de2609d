#include "veridyn/files/model_origin.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iterator>

#include "files/yaml/yaml_node.hpp"
#include "files/yaml/yaml_text.hpp"
#include "files/file_hash.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

std::string utc_now() {
  std::time_t seconds = std::time(nullptr);
  if (const char* const fixed = std::getenv("SOURCE_DATE_EPOCH")) {
    char* end = nullptr;
    const long long given = std::strtoll(fixed, &end, 10);
    if (end != fixed && *end == '\0') seconds = static_cast<std::time_t>(given);
  }
  std::tm utc{};
  std::array<char, 32> text{};
  if (::gmtime_r(&seconds, &utc) == nullptr) return {};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text.data();
}

}  // namespace

ModelOrigin origin_now(const std::string& command, const std::vector<std::string>& inputs) {
  ModelOrigin out{utc_now(), VERIDYN_VERSION, command, {}};
  std::vector<std::string> seen;
  for (const std::string& path : inputs) {
    if (path.empty() || std::find(seen.begin(), seen.end(), path) != seen.end()) continue;
    seen.push_back(path);
    out.inputs.push_back({path.substr(path.find_last_of('/') + 1), sha256_of_file(path)});
  }
  return out;
}

std::optional<ModelOrigin> read_origin(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  require(file.is_open(), path, ": found no such file, expected a MODEL file.");
  const std::string content(std::istreambuf_iterator<char>(file), {});
  YamlSource source{path, {}, {}};
  const YamlNode root = YamlNode::parse(content, source);
  const auto node = root.is_map() ? root.find("made") : std::nullopt;
  if (!node) return std::nullopt;
  node->allow_keys({"date", "veridyn", "command", "inputs"});
  ModelOrigin origin;
  if (const auto date = node->find("date")) origin.date = date->word("a date");
  if (const auto version = node->find("veridyn")) origin.version = version->word("a version");
  if (const auto command = node->find("command")) origin.command = command->word("a command");
  if (const auto inputs = node->find("inputs")) {
    for (const YamlNode& input : inputs->items("a list of files")) {
      input.allow_keys({"file", "sha256"});
      OriginFile one{input.at("file").word("a file's name"), {}};
      if (const auto hash = input.find("sha256")) one.sha256 = hash->word("a SHA-256");
      origin.inputs.push_back(std::move(one));
    }
  }
  return origin;
}

std::string with_origin(const std::string& yaml, const ModelOrigin& origin) {
  std::string made = "made:\n  date: " + quoted_if_needed(origin.date) +
                     "\n  veridyn: " + quoted_if_needed(origin.version) +
                     "\n  command: " + quoted_if_needed(origin.command) + "\n";
  if (!origin.inputs.empty()) made += "  inputs:\n";
  for (const OriginFile& input : origin.inputs) {
    made += "    - {file: " + quoted_if_needed(input.file) +
            (input.sha256.empty() ? "" : ", sha256: " + quoted_if_needed(input.sha256)) + "}\n";
  }
  const std::size_t name = yaml.find("\ngravity:");
  const std::size_t at = name == std::string::npos ? yaml.size() : name + 1;
  return yaml.substr(0, at) + made + yaml.substr(at);
}

}  // namespace veridyn
