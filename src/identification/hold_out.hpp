#pragma once

#include <cstddef>

namespace veridyn {

/// How recordings are divided into held-out parts, and how many parts have to agree: the same in every
/// comparison of two models.
struct HoldOut {
  std::size_t fewest;  ///< Thresholds::fewest_folds
  double new_share;    ///< Thresholds::new_share

  /// Number of parts of each recording. A single recording has twice as many, contiguous in time.
  std::size_t parts_of_each(std::size_t recordings) const {
    return recordings == 1 ? 2 * fewest : (fewest + recordings - 1) / recordings;
  }

  /// True if all parts agree, or, with many parts, all but one: one recording may be faulty.
  bool enough_agree(std::size_t agree, std::size_t parts) const { return agree + (parts >= fewest ? 1 : 0) >= parts; }
};

}  // namespace veridyn
