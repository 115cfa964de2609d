#pragma once

#include <string>
#include <vector>

#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// Recordings as square-root factors: all that identify() needs of them and not one sample, so that
/// raw data can stay where they were recorded. Sets of one arm merge, in any order and on any
/// number of machines.
struct FactorSet {
  FactorSet() {}  // no aggregate: a list of paths in braces is no FactorSet

  std::string robot;     ///< name of the arm that they were made for
  VectorXd fingerprint;  ///< (n + 1) of its kinematics and of what its file declares as facts
  std::string settings;  ///< Settings of the preprocessing, as text: filter, velocities, decimation
  std::vector<CompressedRecording> recordings;
};

/// Compresses recordings, in parallel; the blocks of a recording are merged where there are many
/// recordings, as identify() does it. An arm whose file has no friction gets it as by
/// JointFriction::kAuto; an identification may leave it out again.
/// @throws InvalidInput  as compress().
FactorSet compress(const Model& arm, const std::vector<std::string>& paths,
                   const PreprocessingOptions& options = {}, int threads = 0);

/// The recordings of both, in this order.
/// @throws InvalidInput  they are of two arms, or were prepared differently.
FactorSet merge(FactorSet a, const FactorSet& b);

/// A factor set as bytes (little-endian, with a checksum).
std::string to_bytes(const FactorSet& factors);

/// The factor set that to_bytes() wrote, equal to the last bit.
///
/// @param source  what messages call the bytes, such as the path of a file.
/// @throws InvalidInput  these are no factors, or damaged ones, or of a later version.
FactorSet factors_from_bytes(const std::string& bytes, const std::string& source = "factors");

/// The same in a file. @throws InvalidInput  also where it cannot be read or written.
void save_factors(const FactorSet& factors, const std::string& path);
FactorSet read_factors(const std::string& path);

/// Identifies the arm from factors; see identify() of recordings. Errors of training are those of
/// the factors' rows: largest errors, errors while moving and plots need samples and are missing.
///
/// @param train  recordings to train on besides, may be empty.
/// @throws InvalidInput  the factors are of another arm or were prepared differently.
Identification identify(const Model& arm, const FactorSet& factors,
                        const std::vector<std::string>& train = {},
                        const std::vector<std::string>& test = {},
                        const IdentificationOptions& options = {});

}  // namespace veridyn
