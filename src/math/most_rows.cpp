#include "math/most_rows.hpp"

#include <unistd.h>

#include <algorithm>

namespace veridyn {
namespace {

constexpr double kShare = 0.25;
constexpr double kUnknown = 2.0 * (1 << 30);  // [bytes] memory assumed if its size is unknown

double physical_memory_bytes() {
  const double pages = static_cast<double>(::sysconf(_SC_PHYS_PAGES));
  const double size = static_cast<double>(::sysconf(_SC_PAGESIZE));
  return pages > 0.0 && size > 0.0 ? pages * size : kUnknown;
}

}  // namespace

double most_rows(double numbers_per_row) {
  return kShare * physical_memory_bytes() / (sizeof(double) * std::max(1.0, numbers_per_row));
}

}  // namespace veridyn
