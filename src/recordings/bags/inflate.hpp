#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace veridyn::bags {

/// Result of decompression.
struct Inflated {
  std::string bytes;   ///< the part that could be decompressed
  bool whole = false;  ///< false: truncated or damaged, and `bytes` is its valid beginning
};

/// Decompresses one stream of `compression`: none (or empty), bz2, lz4 (a frame) or zstd. Memory grows with
/// the decompressed data up to `limit` bytes; the result of a longer stream is not whole.
/// @throws InvalidInput  an unknown compression.
Inflated inflate(std::string_view compression, std::string_view packed, std::size_t limit);

/// Largest decompressed size of a chunk, message or database.
constexpr std::size_t kInflateLimit = std::size_t{4} << 30;

}  // namespace veridyn::bags
