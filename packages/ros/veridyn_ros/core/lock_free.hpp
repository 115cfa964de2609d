#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace veridyn_ros {

/// The latest value that one thread writes, for one thread that reads; neither waits for the other. Three
/// buffers: one being written, one being read, one between them.
template <typename T>
class Snapshot {
 public:
  void write(const T& value) noexcept {
    slots_[writing_] = value;
    writing_ = between_.exchange(static_cast<std::uint8_t>(writing_ | kNew), std::memory_order_acq_rel) & kSlotMask;
  }

  /// Reads a value into `value`; false if there is none since the last read.
  bool read(T& value) noexcept {
    if ((between_.load(std::memory_order_acquire) & kNew) == 0) return false;
    reading_ = between_.exchange(reading_, std::memory_order_acq_rel) & kSlotMask;
    value = slots_[reading_];
    return true;
  }

 private:
  static constexpr std::uint8_t kSlotMask = 3, kNew = 4;
  std::array<T, 3> slots_{};
  std::uint8_t writing_ = 0, reading_ = 1;
  std::atomic<std::uint8_t> between_{2};
};

/// Lock-free single-producer, single-consumer queue; push() returns false if it is full, pop() if it is empty.
template <typename T, std::size_t Size>
class Queue {
 public:
  bool push(const T& value) noexcept {
    const std::size_t at = tail_.load(std::memory_order_relaxed);
    if (at - head_.load(std::memory_order_acquire) >= Size) return false;
    slots_[at % Size] = value;
    tail_.store(at + 1, std::memory_order_release);
    return true;
  }
  bool pop(T& value) noexcept {
    const std::size_t at = head_.load(std::memory_order_relaxed);
    if (at == tail_.load(std::memory_order_acquire)) return false;
    value = slots_[at % Size];
    head_.store(at + 1, std::memory_order_release);
    return true;
  }

 private:
  std::array<T, Size> slots_{};
  std::atomic<std::size_t> head_{0}, tail_{0};
};

}  // namespace veridyn_ros
