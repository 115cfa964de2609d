#include "diagnosis/stages/investigation.hpp"

#include "identification/velocity_choice.hpp"

#include <algorithm>
#include <cmath>

namespace veridyn {

bool Investigation::asks_for(const std::string& effect) const {
  const std::vector<std::string>& some = options.effects;
  return some.empty() || std::find(some.begin(), some.end(), effect) != some.end();
}

Identification Investigation::look(const Model& any) const {
  return d.changes ? evaluate(any, train, test, options.identification)
                   : identify(any, train, test, options.identification);
}

QuestionList Investigation::list() const {
  QuestionList out;
  out.wanted = options.effects;
  out.changes = d.changes;
  out.limits = options.thresholds;
  return out;
}

Questions ask(const Investigation& x, const QuestionList& list, const Identification& start) {
  Inquiry q = prepare(start, x.train, {}, list, x.options.identification);
  auto& all = q.augmented.hypotheses;
  all.erase(std::remove_if(all.begin(), all.end(),
                           [&x](const Hypothesis& h) { return x.refused.count(h.family) != 0; }),
            all.end());
  NormalBlocks data(q.train, q.columns, NormalBlocks::EmptiedFactors());
  return {std::move(q), std::move(data)};
}

double log_training_error(const Identification& id) {
  return log_training_errors(id).sum();
}

}  // namespace veridyn
