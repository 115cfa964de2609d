#pragma once

#include <string>
#include <vector>

#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// Recordings as square-root factors, from which identify() works without samples, so that raw data can stay
/// where they were recorded. Sets of one arm can be merged in any order and on any number of machines.
struct FactorSet {
  // not an aggregate, so that a list of paths in braces is not taken for a FactorSet
  FactorSet() {}

  std::string robot;     ///< name of the arm
  VectorXd fingerprint;  ///< (n + 1) fingerprint of its kinematics and of the known values in its file
  std::string settings;  ///< settings of the preprocessing as text: filter, velocities, decimation
  std::vector<CompressedRecording> recordings;
};

/// Compresses recordings in parallel; of many recordings the blocks of each are merged, as in
/// identify(). An arm whose file has no friction gets plain friction (JointFriction::kAuto), which an
/// identification may drop.
/// @throws InvalidInput  as the compress() of one recording.
FactorSet compress(const Model& arm, const std::vector<std::string>& paths,
                   const PreprocessingOptions& options = {}, int threads = 0);

/// Concatenates the recordings of both, in this order.
/// @throws InvalidInput  the two belong to different arms or have different settings.
FactorSet merge(FactorSet a, const FactorSet& b);

/// A factor set as bytes (little-endian, with a checksum).
std::string to_bytes(const FactorSet& factors);

/// The factor set that to_bytes() wrote, equal to the last bit.
///
/// @param source  name of the bytes in messages, such as the path of a file. @throws InvalidInput
/// the bytes are no factors, are damaged, or have a later version.
FactorSet factors_from_bytes(const std::string& bytes, const std::string& source = "factors");

/// Writes and reads these bytes as a file. @throws InvalidInput  also if it cannot be read or written.
void save_factors(const FactorSet& factors, const std::string& path);
FactorSet read_factors(const std::string& path);

/// Identifies the arm from factors, like identify() from recordings. Training errors refer to the factors'
/// rows: largest errors, errors while moving and plots need samples and are missing.
///
/// @param train  further recordings to train on, may be empty.
/// @throws InvalidInput  the factors are of another arm or were prepared differently.
Identification identify(const Model& arm, const FactorSet& factors,
                        const std::vector<std::string>& train = {},
                        const std::vector<std::string>& test = {},
                        const IdentificationOptions& options = {});

}  // namespace veridyn
