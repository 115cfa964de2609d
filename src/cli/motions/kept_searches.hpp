#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "veridyn/math/types.hpp"

namespace veridyn::cli {

/// Finished searches of one command in a file, a line each, so that the same command goes on after a
/// kill. Threads may share it.
class KeptSearches {
 public:
  /// @param command  everything that the searches depend on; the file's first line has its hash.
  /// @throws InvalidInput  the file is of another command, or cannot be written.
  KeptSearches(std::string path, const std::string& command);

  std::optional<VectorXd> find(int start) const;
  void keep(int start, const VectorXd& numbers);

 private:
  std::string path_;
  std::map<int, VectorXd> all_;
  std::mutex writing_;
};

}  // namespace veridyn::cli
