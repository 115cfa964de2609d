#pragma once

#include <string>
#include <vector>

#include "identification/many_recordings.hpp"
#include "identification/validation.hpp"

namespace veridyn {

/// Training and held-out recordings with the errors of an identification's parameters.
struct MeasuredRecordings {
  std::vector<CompressedRecording> held_out;  ///< facts only
  std::vector<MeasuredRecording> train, test;
};

/// The two passes over recordings of an identification; this implementation runs on one machine.
class RecordingPasses {
 public:
  virtual ~RecordingPasses() = default;
  virtual std::vector<CompressedRecording> compress(const Model& arm, const std::vector<std::string>& train,
                                                    const PreprocessingOptions& how, int threads) const {
    return compress_many(arm, train, how, threads);
  }
  /// Errors of id.parameters on the recordings of id.factors and on held-out ones.
  virtual MeasuredRecordings measure(const Model& arm, const std::vector<std::string>& test, int threads,
                                     const Identification& id) const;
};

/// identify_compressed() and validate() with these passes.
Identification identify_compressed(const Model& arm, std::vector<CompressedRecording> trained,
                                   const std::vector<std::string>& train, const std::vector<std::string>& test,
                                   const IdentificationOptions& options, const RecordingPasses& passes);
void validate(const Model& arm, const std::vector<std::string>& test, const IdentificationOptions& options,
              const RecordingPasses& passes, Identification& id);

}  // namespace veridyn
