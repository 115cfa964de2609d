#pragma once

#include <algorithm>
#include <string>

namespace veridyn {

/// Text of a file for a message: on one line, without control characters, and cut to `longest` bytes and "..." if longer.
inline std::string excerpt(std::string found, std::size_t longest = 60) {
  if (found.size() > longest) found = found.substr(0, longest) + "...";
  std::replace_if(
      found.begin(), found.end(), [](char c) { return (c >= 0 && c < ' ') || c == 0x7F; }, '?');
  return found;
}

}  // namespace veridyn
