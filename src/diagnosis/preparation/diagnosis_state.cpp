#include "diagnosis/preparation/diagnosis_state.hpp"

#include <algorithm>

#include "effects/effect_names.hpp"
#include "model/suggestion.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {

std::string normalized_cause(const Model& arm, const std::string& words) {
  if (split_cause(words).place.empty()) {
    const std::vector<std::string>& known = effect_names();
    require(std::find(known.begin(), known.end(), words) != known.end(), "found the unknown effect '", words, "'",
            did_you_mean(words, known), ", expected one of: ", listed(known), ".");
    return words;
  }
  const Cause cause = parse_cause(arm, words);
  const std::optional<FrameIndex> frame = frame_of(cause);
  require(!std::holds_alternative<KinematicError>(cause) || (frame && arm.frames()[frame->value].dh), "cause '", words,
          "': is asked about as a number of a frame's row only, as coupling_error:FRAME.theta.");
  return to_text(arm, cause);
}

bool is_among(const std::vector<std::string>& wanted, const Model& arm, const Cause& cause) {
  return wanted.empty() || std::any_of(wanted.begin(), wanted.end(), [&](const std::string& one) {
           return one == effect_of(cause) || one == to_text(arm, cause);
         });
}

bool DiagnosisState::tests_effect(const std::string& effect) const {
  const std::vector<std::string>& some = options.effects;
  return some.empty() || std::any_of(some.begin(), some.end(), [&effect](const std::string& one) {
           return split_cause(one).effect == effect;
         });
}

bool DiagnosisState::tests_cause(const Cause& cause) const {
  return is_among(options.effects, arm, cause);
}

Identification DiagnosisState::fit(const Model& any) const {
  return d.changes ? evaluate(any, train, test, options.identification)
                   : identify(any, train, test, options.identification);
}

}  // namespace veridyn
