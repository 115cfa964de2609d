#pragma once

#include <cstdint>
#include <string>

#include "veridyn/control/load_cell.hpp"

namespace veridyn {

/// A binary frame of a load cell: its number, a raw reading, and their CRC.
inline std::string frame(std::uint16_t number, std::int32_t raw) {
  std::uint8_t bytes[10] = {0xA5, 0x5A};
  const auto word = static_cast<std::uint32_t>(raw);
  bytes[2] = static_cast<std::uint8_t>(number & 0xFF);
  bytes[3] = static_cast<std::uint8_t>(number >> 8);
  for (int k = 0; k < 4; ++k) bytes[4 + k] = static_cast<std::uint8_t>(word >> (8 * k));
  const std::uint16_t crc = crc16(bytes + 2, 6);
  bytes[8] = static_cast<std::uint8_t>(crc & 0xFF);
  bytes[9] = static_cast<std::uint8_t>(crc >> 8);
  return {reinterpret_cast<const char*>(bytes), sizeof(bytes)};
}

}  // namespace veridyn
