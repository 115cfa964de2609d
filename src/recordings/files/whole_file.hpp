#pragma once

#include <string>
#include <string_view>

#include "recordings/files/byte_stream.hpp"

namespace veridyn {

/// The bytes of a file in memory, which stay valid if another program truncates the file. A file beyond 256
/// MiB is mapped instead, so that only the pages that are read use memory (a bag may contain images); if it
/// is truncated meanwhile, the program ends with SIGBUS.
class WholeFile {
 public:
  /// @param opened  the file, if it is open already.
  /// @throws InvalidInput  the file is missing, unreadable, a folder, or ends before its size.
  explicit WholeFile(const std::string& path, const ByteStream* opened = nullptr);
  ~WholeFile();
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;

  std::string_view bytes() const { return {data_, size_}; }

 private:
  char* data_ = nullptr;
  std::size_t size_ = 0;
};

/// The first bytes of a file, at most `count`; empty for a folder or where it cannot be read.
std::string first_bytes(const std::string& path, std::size_t count);

}  // namespace veridyn
