#include <cmath>
#include <cstdlib>
#include <cstring>

#include "veridyn/control/load_cell.hpp"

namespace veridyn {
namespace {

constexpr std::uint8_t kFirst = 0xA5, kSecond = 0x5A;
constexpr std::size_t kFrame = 10;

bool is_blank(char c) {
  return c == ' ' || c == '\t';
}

bool is_field_separator(char c) {
  return is_blank(c) || c == ',' || c == ';' || c == ':' || c == '=';
}

// True if the field is one decimal number, not "nan", "inf", "0x1F" or "3.2N"; `out` is set to it.
bool parse_field(const char* begin, const char* end, double& out) {
  char number[48] = {};
  const auto length = static_cast<std::size_t>(end - begin);
  if (length == 0 || length >= sizeof(number)) return false;
  for (const char* c = begin; c != end; ++c) {
    if (std::strchr("0123456789.+-eE", *c) == nullptr) return false;
  }
  std::memcpy(number, begin, length);
  char* stop = nullptr;
  out = std::strtod(number, &stop);
  return *stop == '\0' && std::isfinite(out);
}

// True if the part of a line before its last field is allowed: nothing, or numbers, such as a time,
// optionally after a name with a colon or an equals sign. Other words have another meaning: "ERR 12".
bool is_reading_prefix(const char* begin, const char* end) {
  while (end > begin && end[-1] != ':' && end[-1] != '=') {
    const char* field = end;
    while (field > begin && !is_field_separator(field[-1])) --field;
    double ignored = 0.0;
    if (field < end && !parse_field(field, end, ignored)) return false;
    end = field > begin && field[-1] != ':' && field[-1] != '=' ? field - 1 : field;
  }
  return true;
}

// True if a line with printable bytes ends with a number after an allowed prefix; `out` is set to it.
bool parse_reading(const char* line, std::size_t length, double& out) {
  for (std::size_t k = 0; k < length; ++k) {
    const auto c = static_cast<unsigned char>(line[k]);
    if ((c < 32 && c != '\t') || c > 126) return false;
  }
  const char* end = line + length;
  while (end > line && is_blank(end[-1])) --end;
  const char* field = end;
  while (field > line && !is_field_separator(field[-1])) --field;
  double value = 0.0;
  if (!parse_field(field, end, value) || !is_reading_prefix(line, field)) return false;
  out = value;
  return true;
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

bool LoadCellDecoder::add_byte(std::uint8_t byte) noexcept {
  return format_ == LoadCellFormat::kText ? decode_text(byte) : decode_binary(byte);
}

bool LoadCellDecoder::decode_text(std::uint8_t byte) noexcept {
  if (byte != '\n' && byte != '\r') {
    if (length_ < line_.size()) {
      line_[length_++] = static_cast<char>(byte);
    } else {
      overlong_ = true;
    }
    return false;
  }
  const std::size_t length = length_;
  const bool whole = begun_;
  const bool sound = whole && !overlong_;
  length_ = 0;
  overlong_ = false;
  begun_ = true;
  if (length == 0) return false;
  if (sound && parse_reading(line_.data(), length, raw_)) return true;
  if (whole) ++refused_;
  return false;
}

bool LoadCellDecoder::decode_binary(std::uint8_t byte) noexcept {
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
    // The next byte may be the start of a frame.
    --length_;
    std::memmove(line_.data(), line_.data() + 1, length_);
  }
  return false;
}

}  // namespace veridyn
