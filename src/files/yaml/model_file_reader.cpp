#include <cmath>

#include "veridyn/math/require.hpp"
#include "math/numbers.hpp"
#include "veridyn/files/model_file.hpp"
#include "effects/effect_names.hpp"
#include "model/suggestion.hpp"
#include "files/yaml/yaml_axis.hpp"
#include "files/yaml/yaml_body.hpp"
#include "files/yaml/yaml_frames.hpp"
#include "files/yaml/yaml_identified.hpp"
#include "files/yaml/yaml_node.hpp"

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
    const YamlNode node = list_item.with_path(text("effects/", index));
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

// Reads `effects:`; a key of an effect that is not among effect_keys() is a parameter.
std::vector<EffectTerm> read_effects(const YamlNode& list,
                                     const std::vector<std::string>& coordinates,
                                     const std::vector<std::string>& frames) {
  const EffectReader reader(coordinates, frames);
  std::vector<EffectTerm> effects;
  for (const YamlNode& node : list.items("a list of effects"))
    effects.push_back(reader.read(node, effects.size()));
  return effects;
}

class ModelReader {
 public:
  ModelReader(const YamlNode& root, YamlSource& source, const ModelFileOptions& options)
      : root_(root), source_(source), options_(options) {}

  ModelDescription description() {
    read_header();
    read_constants();
    if (const auto box = root_.find("box")) model_.box = read_box(*box);
    for (const YamlNode& node : root_.at("coordinates").items("a list of coordinates"))
      read_coordinate(node);
    if (model_.coordinates.empty()) root_.at("coordinates").fail("no coordinates", "at least one");
    read_crosstalk();
    model_.frames = read_frames(root_.at("frames"), coordinate_names_, convention_);
    if (const auto effects = root_.find("effects")) {
      model_.effects = read_effects(*effects, coordinate_names_, frame_names());
    }
    if (const auto effects = root_.find("arm_effects")) {
      model_.arm_effects = read_effects(*effects, coordinate_names_, frame_names());
    }
    if (const auto identified = root_.find("identified")) {
      model_.identified = read_identified(*identified, static_cast<int>(coordinate_names_.size()));
    }
    model_.constants = source_.constants;
    model_.formulas = source_.formulas;
    return model_;
  }

 private:
  void read_header() {
    if (!root_.is_map()) root_.fail(root_.found(), "a robot file, which begins with 'veridyn: 1'");
    const auto version = root_.find("veridyn");
    if (!version) root_.fail("no 'veridyn: 1'", "a robot file, which begins with it");
    if (version->number() != 1.0) version->fail("version " + version->found(), "'veridyn: 1'");
    root_.allow_keys({"veridyn", "name", "source", "values", "gravity", "constants", "convention", "box",
                      "coordinates", "frames", "effects", "arm_effects", "identified", "made"});
    model_.name = root_.at("name").word("the robot's name");
    if (const auto source = root_.find("source"))
      model_.source = source->word("where the numbers come from");
    if (const auto values = root_.find("values")) {
      const std::string word = values->word("facts or prior");
      if (word != "facts" && word != "prior") values->fail(values->found(), "facts or prior");
      if (word == "prior") model_.values = RobotValues::kPrior;
    }
    if (const auto convention = root_.find("convention"))
      convention_ = read_convention(*convention);
  }

  void read_constants() {
    if (const auto constants = root_.find("constants")) {
      for (const YamlNode::Entry& entry : constants->entries("a map of constants"))
        read_constant(entry);
    }
    std::vector<std::string> names;
    for (const auto& [name, value] : source_.constants) names.push_back(name);
    for (const auto& [name, value] : options_.constants) {
      if (source_.constants.count(name) > 0) continue;
      root_.fail("no constant '" + name + "'" + did_you_mean(name, names),
                 "one of: " + listed(names));
    }
    // Gravity is read after the constants, which it may use.
    if (const auto gravity = root_.find("gravity")) {
      const std::vector<double> g = gravity->numbers(3, "three numbers, m/s^2 in the world");
      model_.gravity = {g[0], g[1], g[2]};
    }
  }

  void read_constant(const YamlNode::Entry& entry) {
    try {
      require_constant_name(entry.key);
    } catch (const InvalidInput& reason) {
      entry.key_node.fail(text("the constant ", reason.what()), "a name of letters, digits and _");
    }
    const auto replaced = options_.constants.find(entry.key);
    const double value =
        replaced == options_.constants.end() ? entry.value.number() : replaced->second;
    if (!std::isfinite(value)) entry.value.fail(text("the override ", value), "a finite number");
    source_.constants[entry.key] = value;
  }

  void read_coordinate(const YamlNode& list_item) {
    list_item.allow_keys({"name", "limits", "drive_gain", "drive_gain_std", "recorded"});
    Coordinate c;
    c.name = list_item.at("name").word("the coordinate's name");
    const YamlNode node = list_item.with_path("coordinates/" + c.name);
    c.limits = {-kInfinity, kInfinity, kInfinity, kInfinity, kInfinity};
    if (const auto limits = node.find("limits")) c.limits = read_limits(*limits);
    if (const auto gain = node.find("drive_gain")) c.drive_gain = gain->number();
    if (const auto recorded = node.find("recorded")) c.recorded = read_channel(*recorded);
    if (const auto std = node.find("drive_gain_std")) {
      c.drive_gain_deviation = std->number_or_infinity();
      if (c.drive_gain_deviation < 0.0)
        std->fail("the negative standard deviation " + std->found(), "0 or more");
    }
    for (const Coordinate& other : model_.coordinates) {
      if (other.name == c.name)
        list_item.fail("a second coordinate '" + c.name + "'", "unique names");
    }
    if (model_.coordinates.size() == kMostCoordinates)
      list_item.fail(text("a coordinate beyond ", kMostCoordinates), text("at most ", kMostCoordinates));
    coordinate_names_.push_back(c.name);
    model_.coordinates.push_back(std::move(c));
  }

  static RecordedChannel read_channel(const YamlNode& node) {
    node.allow_keys({"torque_gain", "torque_delay", "position_offset", "torque_crosstalk"});
    RecordedChannel channel;
    if (const auto gain = node.find("torque_gain")) channel.torque_gain = gain->positive_number();
    if (const auto delay = node.find("torque_delay")) channel.torque_delay = delay->number();
    if (const auto offset = node.find("position_offset"))
      channel.position_offset = offset->number();
    return channel;
  }

  // Reads the crosstalk; needs the names of all coordinates.
  void read_crosstalk() {
    size_t joint = 0;
    for (const YamlNode& node : root_.at("coordinates").items("a list of coordinates")) {
      const size_t own = joint++;
      const auto recorded = node.find("recorded");
      const auto crosstalk = recorded ? recorded->find("torque_crosstalk") : std::nullopt;
      if (!crosstalk) continue;
      for (const YamlNode::Entry& entry : crosstalk->entries("a map {coordinate: share}")) {
        const auto from = std::find(coordinate_names_.begin(), coordinate_names_.end(), entry.key);
        const auto at = static_cast<size_t>(from - coordinate_names_.begin());
        if (from == coordinate_names_.end() || at == own) {
          entry.key_node.fail("'" + entry.key + "'" + did_you_mean(entry.key, coordinate_names_),
                              "another coordinate of: " + listed(coordinate_names_));
        }
        model_.coordinates[own].recorded.torque_crosstalk[{static_cast<int>(at)}] = entry.value.number();
      }
    }
  }

  static Limits read_limits(const YamlNode& node) {
    node.allow_keys({"position", "velocity", "acceleration", "effort"});
    Limits limits{-kInfinity, kInfinity, kInfinity, kInfinity, kInfinity};
    if (const auto position = node.find("position")) {
      const std::vector<YamlNode> ends = position->items("two numbers [lower, upper]");
      if (ends.size() != 2) position->fail(position->found(), "two numbers [lower, upper]");
      limits.lower = ends[0].number_or_infinity();
      limits.upper = ends[1].number_or_infinity();
      if (!(limits.lower < limits.upper)) {
        position->fail(text("[", limits.lower, ", ", limits.upper, "]"), "lower < upper");
      }
    }
    if (const auto velocity = node.find("velocity")) limits.velocity = velocity->positive_number();
    if (const auto acceleration = node.find("acceleration")) {
      limits.acceleration = acceleration->positive_number();
    }
    if (const auto effort = node.find("effort")) limits.effort = effort->positive_number();
    return limits;
  }

  std::vector<std::string> frame_names() const {
    std::vector<std::string> names;
    for (const Frame& frame : model_.frames) names.push_back(frame.name);
    return names;
  }

  const YamlNode& root_;
  YamlSource& source_;
  const ModelFileOptions& options_;
  ModelDescription model_;
  std::optional<DhConvention> convention_;
  std::vector<std::string> coordinate_names_;
};

}  // namespace

Model read_yaml(const std::string& content, const std::string& file,
                const ModelFileOptions& options) {
  YamlSource source{file, {}, {}};
  const YamlNode root = YamlNode::parse(content, source);
  ModelDescription description = ModelReader(root, source, options).description();
  try {
    return Model(std::move(description));
  } catch (const InvalidInput& reason) {
    throw InvalidInput(text(source.file, ": ", reason.what()));
  }
}

}  // namespace veridyn
