#pragma once

#include <string>
#include <vector>

#include "diagnosis/evidence/hypotheses.hpp"
#include "diagnosis/evidence/normal_blocks.hpp"
#include "diagnosis/evidence/selection.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn {

/// Data of one run of tests: the arm with all hypotheses, and the factors of its columns on every
/// recording, in blocks_that_fit().
struct CandidateData {
  AugmentedModel augmented;
  std::vector<CompressedRecording> train, test;
  ColumnSet base;                    ///< columns that are fitted in any case
  std::vector<std::string> columns;  ///< names; `base` and the hypotheses count in them
};

/// Blocks that each of so many recordings keeps for questions about an arm: neighbours are merged
/// until the factors of all take 256 MB, but not to fewer than eight of all recordings together. A
/// function of the arm's joints and bodies only: what is compared has equal blocks.
int blocks_that_fit(const Model& arm, int recordings);

/// @param start  identified, or evaluated where the arm's values are facts.
CandidateData prepare(const Identification& start, const std::vector<std::string>& train,
                const std::vector<std::string>& test, const CandidateList& list,
                const IdentificationOptions& how);

/// The factors of base and hypotheses for another list of the same arm.
CandidateData prepare(const Identification& start, AugmentedModel augmented, bool changes,
                const std::vector<std::string>& train, const std::vector<std::string>& test,
                const IdentificationOptions& how);

}  // namespace veridyn
