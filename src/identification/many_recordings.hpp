#pragma once

#include <string>
#include <vector>

#include "veridyn/identification/factor_set.hpp"

namespace veridyn {

/// compress_all(), for identify(): where there are many recordings, the blocks of each are merged
/// until all recordings together have no more than kMostBlocks of them (but at least one each), so
/// that memory does not grow with a recording's blocks. Clusters of the jackknife are then whole
/// recordings, as they should be where there are many.
std::vector<CompressedRecording> compress_many(const Model& arm,
                                               const std::vector<std::string>& paths,
                                               const PreprocessingOptions& options, int threads);

/// compress() without factors: what is known of a recording beside them.
CompressedRecording compress_facts(const Model& arm, const std::string& path,
                                   const PreprocessingOptions& options, int threads);

/// Merges neighbouring blocks of a recording until it has at most `most`.
void merge_blocks(CompressedRecording& recording, int most);

/// Blocks that each of so many recordings may keep.
int blocks_of_each(int recordings);

/// The arm of a robot file with the friction that is asked for.
class AskedArm {
 public:
  AskedArm(const Model& file, JointFriction friction);
  const Model& used() const { return used_; }
  /// From now on without the rotor inertia that the file does not have. False if there was none.
  bool leave_rotors_out();
  std::string remark() const;  ///< friction_remark()

 private:
  Model file_;
  JointFriction friction_;
  Model used_;
};

/// From factors to a model: fills everything but errors, and may replace id.reason. Rotor inertia
/// that was added and that the recordings cannot tell is left out of the arm and of the factors.
/// False if there is no model.
bool fit_factors(AskedArm& arm, std::vector<CompressedRecording>& recordings,
                 const IdentificationOptions& options, Identification& id);

/// From factors to the parameters of an arm and its model, over base parameters that the recordings
/// determine. Leaves id.model empty where a prior does not let it converge.
void fit_base(const Model& arm, const std::vector<CompressedRecording>& recordings,
              const BaseParameters& base, const IdentificationOptions& options, Identification& id);

/// The errors of training go into the MODEL file with the statistics.
void keep_training_error(Identification& id);

/// @throws InvalidInput  the factors are of another arm, or were prepared otherwise.
void require_factors_of(const Model& arm, const FactorSet& factors,
                        const PreprocessingOptions& how);

/// Whether a file begins as a factor file does.
bool is_factor_file(const std::string& path);

/// identify() of recordings that were compressed before (`trained`, in front) and of others.
Identification identify_compressed(const Model& arm, std::vector<CompressedRecording> trained,
                                   const std::vector<std::string>& train,
                                   const std::vector<std::string>& test,
                                   const IdentificationOptions& options);

}  // namespace veridyn
