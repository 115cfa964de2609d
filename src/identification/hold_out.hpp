#pragma once

#include <cstddef>

namespace veridyn {

/// How recordings are divided into parts that are held out, and how many of these must agree: the same in every
/// comparison of two models.
struct HoldOut {
  std::size_t fewest;  ///< Thresholds::fewest_folds
  double new_share;    ///< Thresholds::new_share

  /// Parts of each recording. Those of a single one follow each other in time and are twice as many.
  std::size_t parts_of_each(std::size_t recordings) const {
    return recordings == 1 ? 2 * fewest : (fewest + recordings - 1) / recordings;
  }

  /// True if all parts agree, or all but one of many, by any amount: a recording can have a fault.
  bool enough_agree(std::size_t agree, std::size_t parts) const { return agree + (parts >= fewest ? 1 : 0) >= parts; }
};

}  // namespace veridyn
