#include <cmath>
#include <cstdlib>
#include <cstring>

#include "veridyn/control/load_cell.hpp"

namespace veridyn {
namespace {

constexpr std::uint8_t kFirst = 0xA5, kSecond = 0x5A;
constexpr std::size_t kFrame = 10;

bool is_number_byte(char c) {
  return (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '+' || c == 'e' || c == 'E';
}

// The last number of a line that holds no bytes but printable ones.
bool last_number(const char* line, std::size_t length, double& out) {
  std::size_t end = length;
  for (std::size_t k = 0; k < length; ++k) {
    const auto c = static_cast<unsigned char>(line[k]);
    if ((c < 32 && c != '\t') || c > 126) return false;
  }
  while (end > 0) {
    while (end > 0 && (line[end - 1] < '0' || line[end - 1] > '9') && line[end - 1] != '.') --end;
    std::size_t begin = end;
    while (begin > 0 && is_number_byte(line[begin - 1])) --begin;
    while (begin < end && (line[begin] == 'e' || line[begin] == 'E')) ++begin;
    if (begin == end) return false;
    char number[48] = {};
    if (end - begin >= sizeof(number)) return false;
    std::memcpy(number, line + begin, end - begin);
    char* stop = nullptr;
    const double value = std::strtod(number, &stop);
    // A name that ends in a digit, as in "HX711", is none.
    const bool in_word = begin > 0 && std::isalpha(static_cast<unsigned char>(line[begin - 1])) != 0;
    if (*stop == '\0' && std::isfinite(value) && !in_word) {
      out = value;
      return true;
    }
    end = begin;
  }
  return false;
}

}  // namespace

std::uint16_t crc16(const std::uint8_t* bytes, std::size_t count) noexcept {
  std::uint16_t crc = 0xFFFF;
  for (std::size_t k = 0; k < count; ++k) {
    crc = static_cast<std::uint16_t>(crc ^ (bytes[k] << 8));
    for (int bit = 0; bit < 8; ++bit)
      crc = static_cast<std::uint16_t>((crc & 0x8000) != 0 ? (crc << 1) ^ 0x1021 : crc << 1);
  }
  return crc;
}

bool LoadCellDecoder::take(std::uint8_t byte) noexcept {
  return format_ == LoadCellFormat::kText ? take_text(byte) : take_binary(byte);
}

bool LoadCellDecoder::take_text(std::uint8_t byte) noexcept {
  if (byte != '\n' && byte != '\r') {
    if (length_ < line_.size()) {
      line_[length_++] = static_cast<char>(byte);
    } else {
      overlong_ = true;
    }
    return false;
  }
  const std::size_t length = length_;
  const bool sound = begun_ && !overlong_;
  length_ = 0;
  overlong_ = false;
  begun_ = true;
  if (length == 0) return false;
  if (sound && last_number(line_.data(), length, raw_)) return true;
  if (sound) ++refused_;
  return false;
}

bool LoadCellDecoder::take_binary(std::uint8_t byte) noexcept {
  line_[length_++] = static_cast<char>(byte);
  const auto at = [&](std::size_t k) { return static_cast<std::uint8_t>(line_[k]); };
  while (length_ > 0) {
    const bool begins = at(0) == kFirst && (length_ < 2 || at(1) == kSecond);
    if (begins && length_ < kFrame) return false;
    if (begins) {
      const auto* bytes = reinterpret_cast<const std::uint8_t*>(line_.data());
      const auto crc = static_cast<std::uint16_t>(at(8) | (at(9) << 8));
      if (crc16(bytes + 2, 6) == crc) {
        const std::uint32_t word = at(4) | (static_cast<std::uint32_t>(at(5)) << 8) |
                                   (static_cast<std::uint32_t>(at(6)) << 16) |
                                   (static_cast<std::uint32_t>(at(7)) << 24);
        raw_ = static_cast<double>(static_cast<std::int32_t>(word));
        length_ = 0;
        return true;
      }
      ++refused_;
    }
    // The next byte may begin a frame.
    --length_;
    std::memmove(line_.data(), line_.data() + 1, length_);
  }
  return false;
}

}  // namespace veridyn
