#pragma once

#include <functional>
#include <string>
#include <vector>

#include "veridyn/identification/factor_set.hpp"

namespace veridyn {

/// Processes that work on one list of recordings: ranks 0 .. size - 1 that can send bytes to each
/// other, by MPI or between the threads of a test.
class Communicator {
 public:
  virtual ~Communicator() = default;
  virtual int rank() const = 0;
  virtual int size() const = 0;
  virtual void send(int to, const std::string& bytes) = 0;
  /// Waits for the next bytes from this rank.
  virtual std::string receive(int from) = 0;
};

/// Receives factors to be stored. `whole` is true for those of all ranks together.
using KeepFactors = std::function<void(const FactorSet& factors, bool whole)>;

/// identify() with the recordings distributed over ranks; every rank calls it with the same arguments.
///
/// Each rank compresses its share, rank 0 collects the factors in the order of the list, and each rank
/// measures the errors of its own recordings. The result is that of identify() on one machine, for any number
/// of ranks. A recording that cannot be read or used is skipped and listed in `unusable_recordings` of the
/// result.
///
/// @param keep  called repeatedly on every rank with its factors so far, so that they survive the
/// failure of a rank, and on rank 0 once with those of all ranks. May be empty.
/// @returns  the result at rank 0; on other ranks only status and reason are valid.
/// @throws InvalidInput  on every rank: no recording could be used, known masses were given, or
/// identify() refuses the arguments.
Identification identify(const Model& arm, const std::vector<std::string>& train,
                        const std::vector<std::string>& test, const IdentificationOptions& options,
                        Communicator& ranks, const KeepFactors& keep = {});

}  // namespace veridyn
