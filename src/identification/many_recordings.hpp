#pragma once

#include <functional>
#include <string>
#include <vector>

#include "veridyn/identification/factor_set.hpp"

namespace veridyn {

/// compress_all() for identify(): with many recordings the blocks of each are merged until all recordings
/// together have at most blocks_of_all blocks (at least one each), which bounds the memory. The clusters of
/// the jackknife are then whole recordings.
std::vector<CompressedRecording> compress_many(const Model& arm,
                                               const std::vector<std::string>& paths,
                                               const PreprocessingOptions& options, int threads);

/// compress() without factors: only the facts about a recording.
CompressedRecording compress_facts(const Model& arm, const std::string& path,
                                   const PreprocessingOptions& options, int threads);

/// Compresses the recordings of a list in parallel by read(path, threads); the result has the order of the
/// list.
std::vector<CompressedRecording> compress_each(const std::vector<std::string>& paths, int threads,
                                         const std::function<CompressedRecording(const std::string&, int)>& read);

/// Merges neighbouring blocks, joint by joint, so that half as many remain.
void merge_pairs(std::vector<std::vector<SquareRootInformation>>& blocks);

/// Merges neighbouring blocks of a recording until at most `most` remain.
void merge_blocks(CompressedRecording& recording, int most);

/// Number of blocks that each of several recordings may keep.
int blocks_of_each(int recordings);

/// The arm of a robot file with the chosen friction.
class AskedArm {
 public:
  AskedArm(const Model& file, JointFriction friction);
  const Model& effective_arm() const { return used_; }
  /// Removes the rotor inertia that with_friction() added. False if there was none.
  bool drop_rotors();
  std::string remark() const;  ///< friction_remark()

 private:
  Model file_;
  JointFriction friction_;
  Model used_;
};

/// Computes the model from factors: fills everything except errors, and may replace id.reason. Removes rotor
/// inertia that with_friction() added and the recordings do not determine, from the arm and from the factors.
/// False if there is no model.
bool fit_factors(AskedArm& arm, std::vector<CompressedRecording>& recordings,
                 const IdentificationOptions& options, Identification& id);

/// Computes the parameters of an arm and its model from factors, over the base parameters that the recordings
/// determine. id.model stays empty if the fit with a prior does not converge.
/// @param joints  joint_totals() of the recordings.
void fit_base(const Model& arm, const std::vector<CompressedRecording>& recordings,
              std::vector<SquareRootInformation> joints, const BaseParameters& base,
              const IdentificationOptions& options, Identification& id);

/// Stores the errors of training in the model, with the statistics.
void store_training_error(Identification& id);

/// @throws InvalidInput  the factors belong to another arm, or were computed with other settings.
void require_factors_of(const Model& arm, const FactorSet& factors,
                        const PreprocessingOptions& how);

/// True if the direction is known from which some joint came to rest.
/// @param poses  names of recordings of poses in memory.
bool is_approached(const PreprocessingOptions& how, const std::vector<std::string>& poses);

/// identify() from poses in memory.
Identification identify_at_rest(const Model& file, const std::vector<std::string>& train,
                                const std::vector<std::string>& test, const IdentificationOptions& options);

/// True if the file has the header of a factor file.
bool is_factor_file(const std::string& path);

/// Joints whose velocities were derived from the position when the factors were computed.
std::vector<JointIndex> joints_with_derived_velocities(const FactorSet& factors);

/// identify() of recordings that were compressed earlier (`trained`, which come first) and of others.
Identification identify_compressed(const Model& arm, std::vector<CompressedRecording> trained,
                                   const std::vector<std::string>& train,
                                   const std::vector<std::string>& test,
                                   const IdentificationOptions& options);

}  // namespace veridyn
