#pragma once

#include "identification/base_solution.hpp"

namespace veridyn {

/// The statistics of an identification for its model file; numbers are rounded to nine digits.
///
/// @param solution  unconstrained solution. @param beta  (base) values that follow from the model's parameters.
IdentifiedBase identified_base(const BaseParameters& base,
                               const std::vector<StandardParameter>& parameters,
                               const BaseSolution& solution, const VectorRef& beta,
                               const std::vector<CompressedRecording>& recordings);

}  // namespace veridyn
