#pragma once

#include <cstddef>

/// How recordings are divided into parts that are held out, and how many of these must agree. The same
/// everywhere: numbers with their inequalities and reasons.
namespace veridyn::hold_out {

/// recordings >= kManyRecordings: each is held out as a whole.
constexpr std::size_t kManyRecordings = 4;
/// parts of a single recording = kPartsOfOne, of each of two or three = kPartsOfFew: with six parts or more a
/// signed-rank test reaches 5 %.
constexpr std::size_t kPartsOfOne = 8, kPartsOfFew = 2;
/// parts >= kManyParts: one of them may disagree, by any amount, since a recording can have a fault.
constexpr std::size_t kManyParts = 4;
/// share of a column's norm that parts determine < kHardlyDetermined: such directions (asymmetric Coulomb friction
/// beside an offset differs at rest alone) keep the values of all parts, which they would else leave by far.
constexpr double kHardlyDetermined = 1e-3;
/// residuals count as independent every kUsualIndependence [s] = TorqueNoise::seconds.
constexpr double kUsualIndependence = 0.1;

/// True if enough of the parts agree.
inline bool enough_agree(std::size_t agree, std::size_t parts) {
  return agree + (parts >= kManyParts ? 1 : 0) >= parts;
}

}  // namespace veridyn::hold_out
