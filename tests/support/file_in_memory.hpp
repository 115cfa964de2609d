#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <string>
#include <string_view>

#include "veridyn/math/require.hpp"

namespace veridyn {

/// A file that is on no disk, for readers that take a path.
class FileInMemory {
 public:
  explicit FileInMemory(std::string_view bytes) : file_(::memfd_create("bytes", MFD_CLOEXEC)) {
    require(file_ >= 0, "no file in memory.");
    while (!bytes.empty()) {
      const ssize_t more = ::write(file_, bytes.data(), bytes.size());
      require(more > 0, "no room for a file in memory.");
      bytes.remove_prefix(static_cast<std::size_t>(more));
    }
  }
  ~FileInMemory() { ::close(file_); }
  FileInMemory(const FileInMemory&) = delete;
  FileInMemory& operator=(const FileInMemory&) = delete;

  std::string path() const { return "/proc/self/fd/" + std::to_string(file_); }

 private:
  int file_;
};

}  // namespace veridyn
