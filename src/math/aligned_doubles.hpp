#pragma once

#include <algorithm>
#include <cstddef>
#include <new>

namespace veridyn {

/// Scratch memory for kernels, aligned for the widest vectors; grows and is kept.
class AlignedDoubles {
 public:
  AlignedDoubles() = default;
  ~AlignedDoubles() { ::operator delete(data_, kAlignment); }
  AlignedDoubles(const AlignedDoubles&) = delete;
  AlignedDoubles& operator=(const AlignedDoubles&) = delete;

  /// At least `count` doubles, with whatever they held before.
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
