#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "veridyn/control/load_cell.hpp"

namespace veridyn {

/// Bytes between the system and the decoder, which returns one decode_reading at a time.
class WaitingBytes {
 public:
  explicit WaitingBytes(LoadCellFormat format) : decoder_(format) {}

  std::uint8_t* buffer() { return bytes_.data(); }
  std::size_t size() const { return bytes_.size() - 1; }
  /// Declares that buffer() now holds `count` bytes; with `line`, the end of a line is appended.
  void set_filled(std::size_t count, bool line = false) {
    at_ = 0;
    end_ = count;
    if (line) bytes_[end_++] = '\n';
  }
  /// True: the decoder completed a reading. False: all bytes are consumed, without another reading.
  bool decode_reading() {
    while (at_ < end_) {
      if (decoder_.add_byte(bytes_[at_++])) return true;
    }
    return false;
  }
  /// One poll of a line: `read` puts bytes into buffer() and returns their number, zero if there are no more
  /// now. At most 64 reads, to bound the time. @returns 1 if there is a reading.
  template <typename Read>
  int poll(const Read& read) {
    if (decode_reading()) return 1;
    for (int k = 0; k < 64; ++k) {
      const std::size_t got = read();
      if (got == 0) return 0;
      set_filled(got);
      if (decode_reading()) return 1;
    }
    return 0;
  }
  LoadCellDecoder& decoder() { return decoder_; }
  const LoadCellDecoder& decoder() const { return decoder_; }

 private:
  LoadCellDecoder decoder_;
  std::array<std::uint8_t, 513> bytes_{};
  std::size_t at_ = 0, end_ = 0;
};

/// A serial line through the terminal interface of the system: for devices that libserialport does not list,
/// such as pseudo-terminals and Bluetooth lines, and for builds without that library.
/// @throws InvalidInput  it cannot be opened, is no terminal, or does not support the speed.
std::unique_ptr<ForceSource> open_terminal_line(const std::string& device, int baud,
                                                LoadCellFormat format);

}  // namespace veridyn
