#include "diagnosis/shapes/inquiry.hpp"

#include <utility>

namespace veridyn {

namespace {

// Held-out errors are those of every row, as recorded.
PreprocessingOptions as_recorded(const IdentificationOptions& how) {
  PreprocessingOptions out = how.test_preprocessing.value_or(how.preprocessing);
  out.stale_rows = StaleRows::kKept;
  out.left_out.clear();
  return out;
}

}  // namespace

Inquiry prepare(const Identification& start, AugmentedModel augmented, bool changes,
                const std::vector<std::string>& train, const std::vector<std::string>& test,
                const IdentificationOptions& how) {
  Inquiry q{std::move(augmented), {}, {}, {}, {}};
  q.train = compress_all(q.augmented.model, train, how.preprocessing, how.threads);
  q.test = compress_all(q.augmented.model, test, as_recorded(how), how.threads);
  if (!changes) {
    const Model& arm = *start.model;
    const std::vector<std::string> names = parameter_names(standard_parameters(arm));
    for (const int j : base_parameters(arm).independent) {
      q.base.push_back(static_cast<int>(q.columns.size()));
      q.columns.push_back(names[static_cast<size_t>(j)]);
    }
  }
  for (const Hypothesis& h : q.augmented.hypotheses)
    q.columns.insert(q.columns.end(), h.columns.begin(), h.columns.end());
  return q;
}

Inquiry prepare(const Identification& start, const std::vector<std::string>& train,
                const std::vector<std::string>& test, const QuestionList& list,
                const IdentificationOptions& how) {
  const Model arm = list.changes ? frozen(*start.model) : *start.model;
  return prepare(start, augmented_model(arm, start.factors, list), list.changes, train, test, how);
}

}  // namespace veridyn
