#pragma once

#include <optional>
#include <string>

#include "recordings/files/byte_stream.hpp"

namespace veridyn::recordings {

/// Kinds of recordings' files, recognised by their first bytes.
enum class FileKind { kText, kBag, kNpz, kMat, kHdf5 };

/// A recording's file, opened once, with its kind.
struct OpenedFile {
  /// @throws InvalidInput  as ByteStream, or a known kind that is not supported (Parquet, Excel, a
  /// compressed file, ...); the message recommends another format.
  explicit OpenedFile(const std::string& file);

  std::string path;
  std::optional<ByteStream> bytes;  ///< bytes from the first one; nullopt: a folder (a bag)
  FileKind kind = FileKind::kText;
};

}  // namespace veridyn::recordings
