#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "diagnosis/causes/geometry.hpp"
#include "diagnosis/shapes/inquiry.hpp"

namespace veridyn {

/// A constant of the robot file that the recordings ask for.
struct WrongConstant {
  Finding finding;
  /// What effects would gain in its place, alone: the best hypothesis of every candidate, best first.
  std::vector<std::pair<Hypothesis, double>> instead;
};

/// The held-out gain of a corrected arm over the arm that q asks about, measured as every other gain
/// is.
double correction_gain(const Model& corrected, const Inquiry& q, const NormalBlocks& data,
                       const std::vector<std::string>& train, const IdentificationOptions& how);

/// A wrong constant goes before any effect that explains no more: asked the other way round it
/// comes back as several effects. Nothing if the recordings do not ask for one.
///
/// @param geometry  profiles of the constants, best first.
/// @param q         the arm as it stands with all effects, to compare with.
std::optional<WrongConstant> wrong_constant(const Model& arm,
                                      const std::vector<GeometryFinding>& geometry,
                                      const Inquiry& q, const NormalBlocks& data,
                                      const std::vector<std::string>& train,
                                      const DiagnosisOptions& options);

}  // namespace veridyn
