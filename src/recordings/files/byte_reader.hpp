#pragma once

#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string_view>

namespace veridyn::bags {

/// Thrown if data end before their announced size, or announce an impossible size.
class CutShort : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Reads little-endian numbers and byte strings, never beyond the end.
/// Every function that reads bytes throws CutShort if fewer are left.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}

  std::size_t position() const { return position_; }
  std::size_t left() const { return bytes_.size() - position_; }

  std::string_view read_bytes(std::uint64_t count) {
    if (count > left()) throw CutShort("fewer bytes than announced");
    const std::string_view part = bytes_.substr(position_, static_cast<std::size_t>(count));
    position_ += static_cast<std::size_t>(count);
    return part;
  }

  void skip(std::uint64_t count) { read_bytes(count); }

  void go_to(std::uint64_t position) {
    if (position > bytes_.size()) throw CutShort("a place beyond the end");
    position_ = static_cast<std::size_t>(position);
  }

  template <typename T>
  T number() {
    const std::string_view raw = read_bytes(sizeof(T));
    std::uint64_t bits = 0;
    for (std::size_t k = sizeof(T); k-- > 0;) bits = bits << 8 | static_cast<unsigned char>(raw[k]);
    T value;
    if constexpr (sizeof(T) == 8) {
      std::memcpy(&value, &bits, 8);
    } else if constexpr (sizeof(T) == 4) {
      const auto half = static_cast<std::uint32_t>(bits);
      std::memcpy(&value, &half, 4);
    } else {
      value = static_cast<T>(bits);
    }
    return value;
  }

  /// A byte string preceded by its length as u32.
  std::string_view sized_text() { return read_bytes(number<std::uint32_t>()); }

 private:
  std::string_view bytes_;
  std::size_t position_ = 0;
};

}  // namespace veridyn::bags
