#pragma once

#include <sstream>

namespace veridyn {

/// A string stream that throws std::bad_alloc: std::ostringstream alone only sets a flag, which is easily
/// overlooked, and gives a truncated text.
class TextStream : public std::ostringstream {
 public:
  TextStream() { exceptions(std::ios::badbit); }
};

}  // namespace veridyn
