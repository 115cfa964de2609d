#pragma once

#include "identification/base_solution.hpp"

namespace veridyn {

/// What a MODEL file keeps of an identification; numbers are rounded to nine digits.
///
/// @param solution  without conditions.
/// @param beta      (base) that the model's parameters have.
IdentifiedBase identified_base(const BaseParameters& base,
                               const std::vector<StandardParameter>& parameters,
                               const BaseSolution& solution, const VectorRef& beta,
                               const std::vector<CompressedRecording>& recordings);

}  // namespace veridyn
