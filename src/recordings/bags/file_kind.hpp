#pragma once

#include <optional>
#include <string>

#include "recordings/files/byte_stream.hpp"

namespace veridyn::recordings {

/// Kinds of files that recordings come in, told by their first bytes.
enum class FileKind { kText, kBag, kNpz, kMat, kHdf5 };

/// A recording's file, opened once, and of what kind it is.
struct OpenedFile {
  /// @throws InvalidInput  as ByteStream does, or a kind that is known and cannot be read (Parquet,
  /// Excel, a compressed file, ...): the message says what to save it as.
  explicit OpenedFile(const std::string& file);

  std::string path;
  std::optional<ByteStream> bytes;  ///< from the first one; none: a folder (a bag)
  FileKind kind = FileKind::kText;
};

}  // namespace veridyn::recordings
