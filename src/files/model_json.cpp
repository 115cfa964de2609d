#include "veridyn/files/model_json.hpp"

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "files/output_file.hpp"
#include "files/expression.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

using Json = nlohmann::ordered_json;

// True for keys whose values are text, even if they have the form of numbers or arithmetic.
bool is_word(const std::string& key) {
  for (const char* const word : {"name", "parent", "effect", "frame", "source", "unit", "file",
                                 "date", "command", "sha256", "convention"}) {
    if (key == word) return true;
  }
  return false;
}

class Converter {
 public:
  explicit Converter(const ModelDescription& model) : constants_(model.constants) {}

  Json value(const YAML::Node& node, const std::string& key) const {
    if (node.IsMap()) {
      Json out = Json::object();
      for (const auto& entry : node) {
        const std::string name = entry.first.Scalar();
        out[name] = value(entry.second, name);
      }
      return out;
    }
    if (node.IsSequence()) {
      Json out = Json::array();
      for (const YAML::Node& one : node) out.push_back(value(one, key));
      return out;
    }
    return node.IsNull() ? Json() : scalar(node, key);
  }

 private:
  Json scalar(const YAML::Node& node, const std::string& key) const {
    const std::string& word = node.Scalar();
    const bool quoted = node.Tag() == "!";
    if (quoted || is_word(key)) return word;
    if (word == "true" || word == "false") return word == "true";
    double number = 0.0;
    try {
      number = evaluate(word, constants_);
    } catch (const std::exception&) {
      return word;
    }
    if (!std::isfinite(number)) return word;
    const bool whole = std::abs(number) < 1e15 && number == std::floor(number) &&
                       word.find_first_not_of("0123456789-") == std::string::npos;
    return whole ? Json(static_cast<long long>(number)) : Json(number);
  }

  const Constants& constants_;
};

}  // namespace

std::string model_json(const Model& arm) {
  const YAML::Node root = YAML::Load(to_yaml(arm));
  return Converter(arm.description()).value(root, "").dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

void save_model_json(const Model& arm, const std::string& path) {
  write_file(path, model_json(arm));
}

}  // namespace veridyn
