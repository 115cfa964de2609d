#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "diagnosis/causes/geometry.hpp"
#include "diagnosis/shapes/candidate_data.hpp"

namespace veridyn {

/// A wrong constant that the recordings indicate.
struct WrongConstant {
  Finding finding;
  /// Gains of effects in its place, alone: the best hypothesis of every candidate, best first.
  std::vector<std::pair<Hypothesis, double>> instead;
};

/// The held-out gain of a corrected arm over the arm of q, measured like every other gain.
double correction_gain(const Model& corrected, const CandidateData& q, const NormalBlocks& data,
                       const std::vector<std::string>& train, const DiagnosisOptions& options);

/// The wrong constant that explains at least as much as any effect; tested before the effects,
/// since otherwise several effects would imitate it. Nullopt if the recordings indicate none.
///
/// @param geometry  profiles of the constants, at least one, best first.
/// @param q         the arm as it stands with all effects, to compare with.
std::optional<WrongConstant> wrong_constant(const Model& arm,
                                      const std::vector<GeometryFinding>& geometry,
                                      const CandidateData& q, const NormalBlocks& data,
                                      const std::vector<std::string>& train,
                                      const DiagnosisOptions& options);

}  // namespace veridyn
