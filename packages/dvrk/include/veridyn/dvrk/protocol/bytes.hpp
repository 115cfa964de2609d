#pragma once

#include <cstddef>
#include <cstdint>

namespace veridyn::dvrk {

/// Bytes that are not owned.
struct ByteView {
  const std::uint8_t* data = nullptr;
  std::size_t size = 0;
};

/// Writable bytes that are not owned.
struct ByteSpan {
  std::uint8_t* data = nullptr;
  std::size_t size = 0;
  operator ByteView() const { return {data, size}; }
};

/// A quadlet (32 bits) in wire order: most significant byte first.
inline std::uint32_t load_quadlet(const std::uint8_t* at) {
  return (static_cast<std::uint32_t>(at[0]) << 24) | (static_cast<std::uint32_t>(at[1]) << 16) |
         (static_cast<std::uint32_t>(at[2]) << 8) | static_cast<std::uint32_t>(at[3]);
}

/// Writes the four bytes of a quadlet, most significant first.
inline void store_quadlet(std::uint8_t* at, std::uint32_t value) {
  at[0] = static_cast<std::uint8_t>(value >> 24);
  at[1] = static_cast<std::uint8_t>(value >> 16);
  at[2] = static_cast<std::uint8_t>(value >> 8);
  at[3] = static_cast<std::uint8_t>(value);
}

/// Quadlets in wire order, read by index. Beyond the end they are zero.
class QuadletView {
 public:
  QuadletView() = default;
  explicit QuadletView(ByteView bytes) : bytes_(bytes) {}

  std::size_t size() const { return bytes_.size / 4; }
  std::uint32_t operator[](std::size_t k) const {
    return k < size() ? load_quadlet(bytes_.data + 4 * k) : 0;
  }
  /// `count` quadlets from `first` on, as far as they exist.
  QuadletView part(std::size_t first, std::size_t count) const {
    if (first >= size()) return {};
    const std::size_t there = size() - first;
    return QuadletView({bytes_.data + 4 * first, 4 * (count < there ? count : there)});
  }
  ByteView bytes() const { return bytes_; }

 private:
  ByteView bytes_;
};

/// Writable quadlets in wire order. Writes beyond the end are ignored.
class QuadletSpan {
 public:
  QuadletSpan() = default;
  explicit QuadletSpan(ByteSpan bytes) : bytes_(bytes) {}

  std::size_t size() const { return bytes_.size / 4; }
  void set(std::size_t k, std::uint32_t value) const {
    if (k < size()) store_quadlet(bytes_.data + 4 * k, value);
  }
  /// `count` quadlets from `first` on, as far as they exist.
  QuadletSpan part(std::size_t first, std::size_t count) const {
    if (first >= size()) return {};
    const std::size_t there = size() - first;
    return QuadletSpan({bytes_.data + 4 * first, 4 * (count < there ? count : there)});
  }
  operator QuadletView() const { return QuadletView(bytes_); }

 private:
  ByteSpan bytes_;
};

}  // namespace veridyn::dvrk
