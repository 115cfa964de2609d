#include "model/yaml/yaml_effects.hpp"

#include "veridyn/math/require.hpp"
#include "model/effect_names.hpp"
#include "model/suggestion.hpp"
#include "model/yaml/yaml_axis.hpp"

namespace veridyn {
namespace {

class EffectReader {
 public:
  EffectReader(const std::vector<std::string>& coordinates, const std::vector<std::string>& frames)
      : coordinates_(coordinates), frames_(frames) {}

  EffectTerm read(const YamlNode& list_item, std::size_t index) const {
    const YamlNode name = list_item.at("effect");
    EffectTerm term;
    term.effect = name.word("the effect's name");
    if (index_of(effect_names(), term.effect) < 0) {
      name.fail("the unknown effect " + name.found() + did_you_mean(term.effect, effect_names()),
                "one of: " + listed(effect_names()));
    }
    term.where = list_item.where();
    const YamlNode node = list_item.placed(text("effects/", index));
    term.axis.coefficients = VectorXd::Zero(coordinates_.size());
    for (const YamlNode::Entry& entry : node.entries("an effect")) read_effect_key(entry, term);
    if (!node.find("axis") && !node.find("frame") && !may_lack_axis(term.effect)) {
      node.fail("no axis", "axis: {coordinate: coefficient}, along which " + term.effect + " acts");
    }
    return term;
  }

 private:
  void read_effect_key(const YamlNode::Entry& entry, EffectTerm& term) const {
    const std::string& key = entry.key;
    if (key == "effect") return;
    if (key == "axis") {
      term.axis.coefficients = read_axis(entry.value, coordinates_).coefficients;
    } else if (key == "offset" && !has_offset_parameter(term.effect)) {
      term.axis.offset = entry.value.number();
    } else if (key == "from") {
      if (!term.from) term.from = Axis{};
      term.from->coefficients = read_axis(entry.value, coordinates_).coefficients;
    } else if (key == "from_offset") {
      if (!term.from)
        entry.key_node.fail("from_offset before from", "from: {coordinate: coefficient} first");
      term.from->offset = entry.value.number();
    } else if (key == "frame") {
      term.frame = entry.value.word("a frame's name");
      require_frame(entry.value, term.frame);
    } else if (key == "values") {
      for (const YamlNode::Entry& e : entry.value.entries("a map of numbers"))
        term.values[e.key] = e.value.number();
    } else if (key == "std") {
      for (const YamlNode::Entry& e : entry.value.entries("a map of numbers")) {
        term.deviations[e.key] = e.value.number_or_infinity();
      }
    } else if (entry.value.is_map() || entry.value.is_list()) {
      entry.key_node.fail("the unknown key '" + key + "'" + did_you_mean(key, effect_keys()),
                          "one of: " + listed(effect_keys()) + ", or a parameter with a number");
    } else {
      term.values[key] = entry.value.number();
    }
  }

  void require_frame(const YamlNode& node, const std::string& name) const {
    if (index_of(frames_, name) >= 0) return;
    node.fail("the unknown frame '" + name + "'" + did_you_mean(name, frames_),
              "one of: " + listed(frames_));
  }

  const std::vector<std::string>& coordinates_;
  const std::vector<std::string>& frames_;
};

}  // namespace

std::vector<EffectTerm> read_effects(const YamlNode& list,
                                     const std::vector<std::string>& coordinates,
                                     const std::vector<std::string>& frames) {
  const EffectReader reader(coordinates, frames);
  std::vector<EffectTerm> effects;
  for (const YamlNode& node : list.items("a list of effects"))
    effects.push_back(reader.read(node, effects.size()));
  return effects;
}

}  // namespace veridyn
