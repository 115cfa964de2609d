#pragma once

#include <algorithm>
#include <string>

namespace veridyn {

/// Text of a file as a message quotes it: on one line, without bytes that a terminal obeys, and not
/// longer than `longest` bytes.
inline std::string excerpt(std::string found, std::size_t longest = 60) {
  if (found.size() > longest) found = found.substr(0, longest) + "...";
  std::replace_if(
      found.begin(), found.end(), [](char c) { return (c >= 0 && c < ' ') || c == 0x7F; }, '?');
  return found;
}

}  // namespace veridyn
