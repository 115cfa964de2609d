#pragma once

#include <string>
#include <string_view>

#include "recordings/files/byte_stream.hpp"

namespace veridyn {

/// The bytes of a file, mapped into memory for reading.
class MappedFile {
 public:
  /// @param opened  the file, if it is open already.
  /// @throws InvalidInput  the file is missing, unreadable or a folder.
  explicit MappedFile(const std::string& path, const ByteStream* opened = nullptr);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  std::string_view bytes() const { return {data_, size_}; }

 private:
  const char* data_ = nullptr;
  std::size_t size_ = 0;
};

/// The first bytes of a file, at most `count`; empty for a folder or where it cannot be read.
std::string first_bytes(const std::string& path, std::size_t count);

}  // namespace veridyn
