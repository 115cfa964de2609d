#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "veridyn/math/types.hpp"

namespace veridyn::cli {

/// Finished parts of one command's work, each a line of numbers in a file, so that the same command can
/// continue after it was killed. Threads may share it.
class KeptResults {
 public:
  /// @param what     beginning of the file, such as "excite: searches".
  /// @param command  all inputs on which the results depend; the file's first line has its hash.
  /// @throws InvalidInput  the file belongs to another command, or cannot be written.
  KeptResults(std::string path, const std::string& what, const std::string& command);

  std::optional<VectorXd> find(int part) const;  ///< numbers of this part; nullopt: not kept yet
  void keep(int part, const VectorRef& numbers);  ///< appends them to the file; find() has only those of earlier runs. @throws InvalidInput  it cannot be written

 private:
  std::string path_;
  std::map<int, VectorXd> all_;
  std::mutex writing_;
};

}  // namespace veridyn::cli
