#pragma once

#include <string>
#include <vector>

#include "diagnosis/causes/hypotheses.hpp"
#include "diagnosis/evidence/normal_blocks.hpp"
#include "diagnosis/evidence/selection.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn {

/// All that one run of questions needs: the arm with all hypotheses, and the factors of its columns
/// on every recording.
struct Inquiry {
  AugmentedModel augmented;
  std::vector<CompressedRecording> train, test;
  ColumnSet base;                    ///< columns that are fitted in any case
  std::vector<std::string> columns;  ///< names; `base` and the hypotheses count in them
};

/// @param start  identified, or evaluated where the arm's values are facts.
Inquiry prepare(const Identification& start, const std::vector<std::string>& train,
                const std::vector<std::string>& test, const QuestionList& list,
                const IdentificationOptions& how);

/// The factors of base and hypotheses for another list of the same arm.
Inquiry prepare(const Identification& start, AugmentedModel augmented, bool changes,
                const std::vector<std::string>& train, const std::vector<std::string>& test,
                const IdentificationOptions& how);

}  // namespace veridyn
