#pragma once

#include <optional>
#include <string>
#include <vector>

#include "diagnosis/causes/geometry.hpp"
#include "diagnosis/shapes/inquiry.hpp"

namespace veridyn {

/// A wrong constant goes before any effect that explains no more: asked the other way round it
/// comes back as several effects. Nothing if the recordings do not ask for one.
///
/// @param geometry  profiles of the constants, best first.
/// @param q         the arm as it stands with all effects, to compare with.
std::optional<Finding> wrong_constant(const Model& arm,
                                      const std::vector<GeometryFinding>& geometry,
                                      const Inquiry& q, const NormalBlocks& data,
                                      const std::vector<std::string>& train,
                                      const DiagnosisOptions& options);

}  // namespace veridyn
