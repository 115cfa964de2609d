#include "diagnosis/stages/diagnosis_state.hpp"

#include "diagnosis/evidence/folds.hpp"
#include "identification/velocity_choice.hpp"

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
  return not_asked.count(to_text(arm, cause)) == 0 && is_among(options.effects, arm, cause);
}

int DiagnosisState::names_left() const {
  const size_t uncounted = contacts + plain_friction;
  return options.max_effects - static_cast<int>(d.findings.size() - std::min(uncounted, d.findings.size()));
}

Identification DiagnosisState::fit(const Model& any) const {
  return d.changes ? evaluate(any, train, test, options.identification)
                   : identify(any, train, test, options.identification);
}

FoldErrors DiagnosisState::fold_errors(const Identification& id) const {
  return veridyn::fold_errors(id, options.identification,
                              d.changes ? FoldValues::kFacts : FoldValues::kFitted, hold_out(options.thresholds));
}

CandidateList DiagnosisState::list() const {
  CandidateList out;
  for (const std::string& one : options.effects) out.wanted.push_back(split_cause(one).effect);
  out.changes = d.changes;
  out.limits = options.thresholds;
  return out;
}

CandidateTests prepare_tests(const DiagnosisState& x, const CandidateList& list, const Identification& start) {
  CandidateData q = prepare(start, x.train, {}, list, x.options.identification);
  auto& all = q.augmented.hypotheses;
  all.erase(std::remove_if(all.begin(), all.end(),
                           [&x](const Hypothesis& h) {
                             return x.refused.count(h) != 0 || !x.tests_cause(h.cause);
                           }),
            all.end());
  NormalBlocks data(q.train, q.columns, NormalBlocks::EmptiedFactors());
  return {std::move(q), std::move(data)};
}

double log_training_error(const Identification& id) {
  return log_training_errors(id).sum();
}

}  // namespace veridyn
