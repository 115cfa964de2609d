#include "files/yaml/yaml_identified.hpp"

#include <fmt/format.h>

#include <cmath>

#include "veridyn/math/require.hpp"
#include "files/yaml/yaml_text.hpp"

namespace veridyn {
namespace {

VectorXd read_numbers(const YamlNode& node, const std::string& expected) {
  const std::vector<YamlNode> items = node.items(expected);
  VectorXd out(items.size());
  for (std::size_t i = 0; i < items.size(); ++i) {
    out[static_cast<Eigen::Index>(i)] = items[i].number();
  }
  return out;
}

MatrixXd read_motion(const YamlNode& node, int clusters, int joints) {
  const std::vector<YamlNode> rows = node.items("a row of numbers for every cluster");
  if (static_cast<int>(rows.size()) != clusters)
    node.fail(node.found(), text("a row for each of the ", clusters, " clusters"));
  MatrixXd out(clusters, joints);
  for (std::size_t c = 0; c < rows.size(); ++c) {
    const std::vector<double> row =
        rows[c].numbers(static_cast<std::size_t>(joints), text(joints, " numbers, one per joint"));
    out.row(c) =
        Eigen::Map<const Eigen::RowVectorXd>(row.data(), joints);
  }
  return out;
}

IdentifiedParameter read_parameter(const YamlNode& node) {
  node.allow_keys({"name", "unit", "value", "free", "std", "of", "factor"});
  IdentifiedParameter p;
  p.name = node.at("name").word("a standard parameter's name");
  p.unit = node.at("unit").word("a unit");
  p.value = node.at("value").number();
  p.free = node.at("free").number();
  for (const YamlNode::Entry& e : node.at("of").entries("coefficients by parameter"))
    p.combination[e.key] = e.value.number();
  if (p.combination.count(p.name) == 0 || p.combination[p.name] != 1.0) {
    node.at("of").fail("a combination without '" + p.name + ": 1'", "the parameter's own name, 1");
  }
  if (const auto factor = node.find("factor"))
    p.scatter = read_numbers(*factor, "a list of numbers, one row of the covariance's factor");
  return p;
}

std::string numbers_text(const VectorXd& values) {
  std::vector<std::string> texts;
  for (const double value : values) texts.push_back(shortest(value));
  return "[" + joined(texts) + "]";
}

std::string parameter_text(const IdentifiedParameter& p) {
  std::vector<std::string> of;
  for (const auto& [name, coefficient] : p.combination)
    of.push_back(quoted_if_needed(name) + ": " + shortest(coefficient));
  std::string out = "    - {name: " + quoted_if_needed(p.name) +
                    ", unit: " + quoted_if_needed(p.unit) + ", value: " + shortest(p.value) +
                    ", free: " + shortest(p.free);
  if (p.scatter.size() > 0) out += fmt::format(", std: {:.4g}", p.scatter.norm());
  out += ",\n       of: {" + joined(of) + "}";
  if (p.scatter.size() > 0) out += ",\n       factor: " + numbers_text(p.scatter);
  return out + "}\n";
}

}  // namespace

IdentifiedBase read_identified(const YamlNode& node, int joints) {
  node.allow_keys({"recordings", "clusters", "error", "noise", "motion", "base"});
  IdentifiedBase out;
  if (const auto recordings = node.find("recordings")) {
    for (const YamlNode& name : recordings->items("a list of file names"))
      out.recordings.push_back(name.word("a file name"));
  }
  const YamlNode clusters = node.at("clusters");
  const double count = clusters.number();
  if (!(count >= 0.0 && count < 1e6 && count == std::floor(count)))
    clusters.fail(clusters.found(), "the number of clusters, 0 or more");
  out.clusters = static_cast<int>(count);
  const auto of_each_joint = [&](const char* key, const char* what) {
    const auto given = node.find(key);
    if (!given) return VectorXd();
    VectorXd values = read_numbers(*given, text("one ", what, " per joint"));
    if (values.size() != joints)
      given->fail(given->found(), text("one ", what, " for each of the ", joints, " joints"));
    return values;
  };
  out.error = of_each_joint("error", "relative error");
  out.noise = of_each_joint("noise", "rms error");
  if (const auto motion = node.find("motion"))
    out.motion = read_motion(*motion, out.clusters, joints);
  for (const YamlNode& item : node.at("base").items("a list of base parameters")) {
    out.parameters.push_back(read_parameter(item));
    const Eigen::Index first = out.parameters.front().scatter.size();
    if (out.parameters.back().scatter.size() != first) {
      item.fail(text("a factor of ", out.parameters.back().scatter.size(), " numbers"),
                text(first, ", as many as the first base parameter has"));
    }
  }
  return out;
}

std::string identified_text(const IdentifiedBase& identified) {
  std::string out =
      "identified:  # base parameters; value: of this model, free: least squares without "
      "conditions,\n"
      "             # of: coefficients of standard parameters, factor: rows of F, covariance of "
      "free = F F'\n";
  std::vector<std::string> recordings;
  for (const std::string& name : identified.recordings)
    recordings.push_back(quoted_if_needed(name));
  out += "  recordings: [" + joined(recordings) + "]\n";
  out += text("  clusters: ", identified.clusters, "\n");
  if (identified.error.size() > 0) out += "  error: " + numbers_text(identified.error) + "\n";
  if (identified.noise.size() > 0) out += "  noise: " + numbers_text(identified.noise) + "\n";
  if (identified.motion.rows() > 0) out += "  motion:\n";
  for (Eigen::Index c = 0; c < identified.motion.rows(); ++c)
    out += "    - " + numbers_text(identified.motion.row(c).transpose()) + "\n";
  out += identified.parameters.empty() ? "  base: []\n" : "  base:\n";
  for (const IdentifiedParameter& p : identified.parameters) out += parameter_text(p);
  return out;
}

}  // namespace veridyn
