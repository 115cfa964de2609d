#pragma once

#include <string>

namespace veridyn::recordings {

/// Kinds of files that recordings come in, told by their first bytes.
enum class FileKind { kText, kBag, kNpz, kMat, kHdf5 };

/// @throws InvalidInput  a kind that is known and cannot be read (Parquet, Excel, a compressed file,
/// ...): the message says what to save it as. A file that is not there is text.
FileKind file_kind(const std::string& path);

}  // namespace veridyn::recordings
