#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace veridyn::bags {

/// What a compressed run of bytes became.
struct Inflated {
  std::string bytes;   ///< what could be unpacked
  bool whole = false;  ///< false: it ends early or is damaged, and `bytes` is its sound beginning
};

/// Unpacks one stream of `compression`: none (or empty), bz2, lz4 (a frame) or zstd.
/// Memory grows with what is really there and never beyond `limit` bytes; a stream that holds more
/// is not whole.
/// @throws InvalidInput  an unknown compression.
Inflated inflate(std::string_view compression, std::string_view packed, std::size_t limit);

/// No chunk, message or database is unpacked beyond this.
constexpr std::size_t kInflateLimit = std::size_t{4} << 30;

}  // namespace veridyn::bags
