#pragma once

#include <algorithm>
#include <cstddef>
#include <new>

namespace veridyn {

/// Scratch memory for kernels, aligned for the widest vectors; it grows and is never released.
class AlignedDoubles {
 public:
  AlignedDoubles() = default;
  ~AlignedDoubles() { ::operator delete(data_, kAlignment); }
  AlignedDoubles(const AlignedDoubles&) = delete;
  AlignedDoubles& operator=(const AlignedDoubles&) = delete;

  /// Returns at least `count` doubles with unspecified contents.
  double* get(std::size_t count) {
    if (count > size_) {
      ::operator delete(data_, kAlignment);
      data_ = nullptr;
      size_ = 0;
      data_ = static_cast<double*>(::operator new(count * sizeof(double), kAlignment));
      size_ = count;
    }
    return data_;
  }

  double* zeros(std::size_t count) {
    double* data = get(count);
    std::fill_n(data, count, 0.0);
    return data;
  }

 private:
  static constexpr std::align_val_t kAlignment{64};
  double* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace veridyn
