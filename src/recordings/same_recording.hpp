#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "veridyn/recordings/recording.hpp"

namespace veridyn {

/// True for two names of one file or folder, links included, and for two files of equal contents.
/// Two empty files are different, and so is a file that does not exist from any other.
bool same_recording(const std::string& a, const std::string& b);

/// A sample of the rows of a recording in which a position changes: the smallest of their hashes, each over all signals but the
/// time of this row and those before. A piece of a recording has its sample in that of the whole, about as dense (Broder, On the resemblance and
/// containment of documents, 1997).
class RowSample {
 public:
  /// Adds rows first to last - 1 of the next piece of the recording.
  void add(const Recording& piece, long first, long last);
  /// In increasing order.
  std::vector<std::uint64_t> hashes();

 private:
  void keep_smallest();

  Recording before_;  // last rows of the piece before
  std::vector<std::uint64_t> hashes_;
  std::uint64_t largest_ = UINT64_MAX;
};

/// Share of a recording's rows that another one holds too, by their samples.
double share_of_rows(const std::vector<std::uint64_t>& of, const std::vector<std::uint64_t>& in);

}  // namespace veridyn
