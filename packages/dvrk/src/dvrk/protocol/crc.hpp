#pragma once

#include <cstdint>

#include "dvrk/protocol/bytes.hpp"

namespace veridyn::dvrk {

/// The CRC of FireWire packets (specification 3.3): polynomial 0x04C11DB7, start 0xFFFFFFFF, most
/// significant bit of each byte first, complemented at the end.
std::uint32_t crc32(ByteView bytes) noexcept;

}  // namespace veridyn::dvrk
