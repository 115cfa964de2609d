#pragma once

#include <sstream>

namespace veridyn {

/// A stream into a text that lets std::bad_alloc through: std::ostringstream alone keeps a flag that
/// is easily overlooked, and gives a truncated text.
class TextStream : public std::ostringstream {
 public:
  TextStream() { exceptions(std::ios::badbit); }
};

}  // namespace veridyn
