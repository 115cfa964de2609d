#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "dvrk/protocol/bytes.hpp"

namespace veridyn::dvrk {

enum class Direction { kToBoard, kToHost };

/// One captured datagram.
struct Vector {
  std::string section;
  std::string name;
  Direction direction;
  int firmware;
  std::string hex;
};

const std::vector<Vector>& vectors();
const Vector& vector_named(const std::string& section, const std::string& name);

std::vector<std::uint8_t> bytes_of(const std::string& hex);
std::string hex_of(ByteView bytes);

}  // namespace veridyn::dvrk
