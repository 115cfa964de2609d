#include "dvrk/protocol/crc.hpp"

#include <array>

namespace veridyn::dvrk {
namespace {

constexpr std::uint32_t kPolynomial = 0x04C11DB7;

// table[k][b]: the effect of byte b followed by k more bytes.
constexpr auto kTable = [] {
  std::array<std::array<std::uint32_t, 256>, 4> table{};
  for (std::uint32_t b = 0; b < 256; ++b) {
    std::uint32_t value = b << 24;
    for (int bit = 0; bit < 8; ++bit)
      value = (value << 1) ^ ((value & 0x80000000U) != 0 ? kPolynomial : 0);
    table[0][b] = value;
  }
  for (std::size_t k = 1; k < 4; ++k) {
    for (std::size_t b = 0; b < 256; ++b) {
      const std::uint32_t before = table[k - 1][b];
      table[k][b] = (before << 8) ^ table[0][before >> 24];
    }
  }
  return table;
}();

}  // namespace

std::uint32_t crc32(ByteView bytes) noexcept {
  std::uint32_t crc = 0xFFFFFFFFU;
  std::size_t k = 0;
  for (; k + 4 <= bytes.size; k += 4) {
    crc ^= load_quadlet(bytes.data + k);
    crc = kTable[3][crc >> 24] ^ kTable[2][(crc >> 16) & 0xFF] ^ kTable[1][(crc >> 8) & 0xFF] ^
          kTable[0][crc & 0xFF];
  }
  for (; k < bytes.size; ++k) crc = (crc << 8) ^ kTable[0][(crc >> 24) ^ bytes.data[k]];
  return ~crc;
}

}  // namespace veridyn::dvrk
