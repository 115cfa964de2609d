#include "veridyn/simulation/hidden_effect.hpp"


#include "files/words.hpp"
#include "veridyn/effects/cause.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/math/require.hpp"
#include "effects/effect_names.hpp"
#include "files/expression.hpp"
#include "model/suggestion.hpp"

namespace veridyn {
namespace {

const char* const kForm = "NAME:JOINT[:KEY=VALUE,...]";

[[noreturn]] void fail(const std::string& asked, const std::string& found,
                       const std::string& expected) {
  throw InvalidInput(text("effect '", asked, "': found ", found, ", expected ", expected, "."));
}

// Adds KEY=VALUE to `out`; throws InvalidInput for another form, a repeated key or no number.
void read_value(const std::string& pair, HiddenEffect& out) {
  const auto equals = pair.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == pair.size()) {
    fail(out.asked, "'" + pair + "'", "KEY=VALUE");
  }
  const std::string key = pair.substr(0, equals);
  const std::string value = pair.substr(equals + 1);
  const bool twice = out.values.count(key) != 0 || (key == "from" && !out.from.empty());
  if (twice) fail(out.asked, "the key '" + key + "' twice", "it once");
  // The key `from` is a time for a contact and a coordinate for a coupling.
  if (key == "from" && out.effect != ExternalContact::kName) {
    out.from = value;
    return;
  }
  try {
    out.values[key] = evaluate(value, {});
  } catch (const InvalidInput& error) {
    fail(out.asked, error.what(), "a number");
  }
}

}  // namespace

HiddenEffect parse_hidden_effect(const std::string& asked) {
  const std::vector<std::string> parts = split(asked, ':');
  HiddenEffect out;
  out.asked = asked;
  out.effect = parts[0];
  bool known = false;
  for (const std::string& name : effect_names()) known = known || name == out.effect;
  if (!known) {
    fail(asked,
         "the unknown effect '" + out.effect + "'" + did_you_mean(out.effect, effect_names()),
         "one of: " + listed(effect_names()));
  }
  if (parts.size() > 3) fail(asked, "more than two ':'", kForm);
  if (parts.size() > 1) out.place = parts[1];
  const ChannelEffect* channel = channel_effect(out.effect);
  if (out.place.empty() && channel != nullptr && channel->whole_arm()) out.place = kWholeArm;
  if (out.place.empty()) fail(asked, "no place", kForm);
  if (parts.size() == 3) {
    for (const std::string& pair : split(parts[2], ',')) read_value(pair, out);
  }
  return out;
}

}  // namespace veridyn
