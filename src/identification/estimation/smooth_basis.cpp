#include "identification/estimation/smooth_basis.hpp"

#include <algorithm>

namespace veridyn {
namespace {

constexpr int kDegree = 3;  // cubic, with the four polynomials of values()

}  // namespace

SmoothBasis::SmoothBasis(BasisKind kind, double low, double high, int intervals, double step)
    : kind_(kind), low_(low), high_(high), intervals_(intervals), step_(step) {}

Eigen::Index SmoothBasis::size() const {
  if (kind_ == BasisKind::kSides) return 2;
  return intervals_ + kDegree + (kind_ == BasisKind::kSided ? 1 : 0);
}

void SmoothBasis::values(double x, double* out) const {
  const double direction = std::clamp(x / step_, -1.0, 1.0);
  if (kind_ == BasisKind::kSides) {
    out[0] = 0.5 * (1.0 - direction);
    out[1] = 0.5 * (1.0 + direction);
    return;
  }
  std::fill(out, out + size(), 0.0);
  const double u = std::clamp((x - low_) / (high_ - low_), 0.0, 1.0) * intervals_;
  const int cell = std::min(static_cast<int>(u), intervals_ - 1);
  const double t = u - cell;
  // Values of the four cubic B-splines that are not zero in this interval.
  out[cell] = (1.0 - t) * (1.0 - t) * (1.0 - t) / 6.0;
  out[cell + 1] = (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0;
  out[cell + 2] = (-3.0 * t * t * t + 3.0 * t * t + 3.0 * t + 1.0) / 6.0;
  out[cell + 3] = t * t * t / 6.0;
  if (kind_ == BasisKind::kSided) out[size() - 1] = direction;
}

}  // namespace veridyn
