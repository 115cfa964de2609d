#include "diagnosis/shapes/candidate_data.hpp"

#include <algorithm>
#include <utility>

#include "diagnosis/evidence/numerics.hpp"
#include "identification/many_recordings.hpp"
#include "math/parallel.hpp"

namespace veridyn {

namespace {

// memory of the factors of one run
constexpr double kMostBytes = 1 << 28;

// Typical number of columns per joint beside the bodies': its own, and those through which other
// joints act on it.

std::vector<CompressedRecording> compress_to_fit(const Model& arm,
                                                 const std::vector<std::string>& paths,
                                                 const PreprocessingOptions& options, int blocks,
                                                 int threads) {
  std::vector<CompressedRecording> out(paths.size());
  const auto count = static_cast<int>(paths.size());
  parallel_for(count, threads, [&](int k) {
    CompressedRecording one = compress(arm, paths[k], options,
                                       threads_of_each(count, threads));
    merge_blocks(one, blocks);
    out[k] = std::move(one);
  });
  return out;
}

// Held-out errors are those of every row, as recorded.
PreprocessingOptions as_recorded(const IdentificationOptions& how) {
  PreprocessingOptions out = how.test_preprocessing.value_or(how.preprocessing);
  out.stale_rows = StaleRows::kKept;
  out.excluded_intervals.clear();
  return out;
}

}  // namespace

int blocks_that_fit(const Model& arm, int recordings) {
  double bytes = 0.0;
  for (int i = 0; i < arm.joints(); ++i) {
    double columns = numerics::kAskedColumns + numerics::kAskedFromOthers * arm.joints();
    for (const int frame : arm.bodies())
      columns += arm.moves(frame, i) ? kBodyParameters : 0;
    bytes += static_cast<double>(sizeof(double)) * columns * columns;
  }
  const int fewest = std::max(1, numerics::kFewestBlocks / std::max(1, recordings));
  return std::max(fewest, static_cast<int>(kMostBytes / (bytes * std::max(1, recordings))));
}

CandidateData prepare(const Identification& start, AugmentedModel augmented, bool changes,
                const std::vector<std::string>& train, const std::vector<std::string>& test,
                const IdentificationOptions& how) {
  CandidateData q{std::move(augmented), {}, {}, {}, {}};
  const int blocks = blocks_that_fit(*start.model, static_cast<int>(train.size()));
  q.train = compress_to_fit(q.augmented.model, train, how.preprocessing, blocks, how.threads);
  q.test = compress_to_fit(q.augmented.model, test, as_recorded(how), 1, how.threads);
  if (!changes) {
    const Model& arm = *start.model;
    const std::vector<std::string> names = parameter_names(standard_parameters(arm));
    for (const int j : base_parameters(arm).independent) {
      q.base.push_back(static_cast<int>(q.columns.size()));
      q.columns.push_back(names[j]);
    }
  }
  for (const Hypothesis& h : q.augmented.hypotheses)
    q.columns.insert(q.columns.end(), h.columns.begin(), h.columns.end());
  return q;
}

CandidateData prepare(const Identification& start, const std::vector<std::string>& train,
                const std::vector<std::string>& test, const CandidateList& list,
                const IdentificationOptions& how) {
  const Model arm = list.changes ? with_fixed_parameters(*start.model) : *start.model;
  return prepare(start, augmented_model(arm, start.factors, list), list.changes, train, test, how);
}

}  // namespace veridyn
