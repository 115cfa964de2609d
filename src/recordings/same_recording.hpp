#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "veridyn/recordings/recording.hpp"

namespace veridyn {

/// True for two names of one file or folder, links included, and for two files of equal contents.
/// Two empty files are different, and so is a file that does not exist from any other.
bool same_recording(const std::string& a, const std::string& b);

/// A sample of the rows of a recording: the smallest hashes of its rows in which a position changes. Each hash
/// covers all signals but the time, of this row and of some before it. The sample of a piece is contained in that
/// of the whole, with about the same density (Broder, On the resemblance and containment of documents, 1997).
class RowSample {
 public:
  /// Adds rows first to last - 1 of the next piece of the recording.
  void add(const Recording& piece, long first, long last);
  /// The hashes in increasing order.
  std::vector<std::uint64_t> hashes();

 private:
  void keep_smallest();  ///< at most kSampled hashes

  Recording before_;  // last rows of the piece before
  std::vector<std::uint64_t> hashes_;
  std::uint64_t largest_ = UINT64_MAX;
};

/// Share of the rows of one recording that another one contains as well, estimated from their samples.
double share_of_rows(const std::vector<std::uint64_t>& of, const std::vector<std::uint64_t>& in);

}  // namespace veridyn
