#pragma once

#include <stdexcept>
#include <string>

#include "veridyn/math/text_stream.hpp"

namespace veridyn {

/// A mistake of the caller, or an unusable file: what() is one line that states where it is, what was found
/// and what was expected.
class InvalidInput : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// All arguments as text, one after the other.
/// @throws std::bad_alloc  there is no more memory.
template <typename... Parts>
std::string text(const Parts&... parts) {
  TextStream out;
  (out << ... << parts);
  return out.str();
}

/// @throws InvalidInput  with the given parts as its message, unless the condition holds.
template <typename... Parts>
void require(bool condition, const Parts&... parts) {
  if (!condition) throw InvalidInput(text(parts...));
}

}  // namespace veridyn
