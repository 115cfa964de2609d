#pragma once

#include <string>
#include <vector>

#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// An identification that knows its question and no answer yet.
Identification described(const Model& arm, const IdentificationOptions& options);

/// Root mean square of the recordings' noise floors, relative, (n); empty if none has one.
VectorXd mean_noise_floor(const std::vector<CompressedRecording>& recordings, int joints);

/// Fills train, test and their errors: those of id.parameters on the recordings of id.factors and
/// on held-out ones.
/// @throws InvalidInput  a held-out recording has no usable samples: no error is not an error of 0.
void validate(const Model& arm, const std::vector<std::string>& test,
              const IdentificationOptions& options, Identification& id);

}  // namespace veridyn
