#pragma once

#include <string>
#include <vector>

#include "diagnosis/candidates/row_constants.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn {

/// A wrong constant that the recordings indicate.
struct GeometryFinding {
  FrameConstant constant;
  double stated = 0.0;                  ///< its value in the robot file
  double found = 0.0;                   ///< the value with the smallest error
  double deviation = 0.0;               ///< standard deviation, jackknife over parts of the
                                        ///< recordings and over whole ones
  double degrees_of_freedom = 1.0;      ///< Degrees of freedom of the deviation
  double gain = 0.0;                    ///< fall of the sum over joints of ln(mean square)
  int base_before = 0, base_after = 0;  ///< numbers of base parameters
};

/// Profiles every constant: all parameters are fitted at every value. A constant is reported if its
/// optimum lies inside the search range, is better than both sides, and does not need more base
/// parameters than the unmodified arm (an improvement by more freedom is flexibility, not
/// geometry). Best first; at most five.
std::vector<GeometryFinding> profile_geometry(const Model& arm,
                                              const std::vector<std::string>& train,
                                              const IdentificationOptions& options,
                                              const Thresholds& limits);

}  // namespace veridyn
