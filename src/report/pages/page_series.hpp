#pragma once

#include <string>
#include <vector>

#include "veridyn/identification/identification.hpp"

namespace veridyn {

inline constexpr Eigen::Index kCurveSamples = 3000;  ///< of one curve, at most

/// One recording as the plots show it.
struct PlottedRecording {
  const char* role = "";                     ///< "held out" or "training"
  const RecordingError* model = nullptr;     ///< the robot as it stands
  const RecordingError* extended = nullptr;  ///< with what was found; null: nothing was
};

/// What the plots of a page show, as JSON: names and units of the joints, and for every recording
/// its motion, measured and modelled torques with as many digits as a plot can use.
///
/// A recording is thinned to about 3000 samples, and to fewer where there are many recordings and
/// joints. Recordings beyond what a page can hold are left out from the end, and counted.
/// @param command  the command line that made them.
std::string series_json(const Model& arm, const std::vector<PlottedRecording>& recordings,
                        const std::string& command);

/// A JSON list with as many digits as a plot of it can use; null where a value is not finite.
std::string number_list(const std::vector<double>& values);

}  // namespace veridyn
