#pragma once

#include "veridyn/recordings/recording.hpp"

namespace veridyn {

/// The base period of a motion that repeats.
struct MotionPeriod {
  double seconds = 0.0;  ///< [s] period; 0: the motion does not repeat
  double confidence =
      0.0;               ///< 1 - d(period), see detect_period(); above 0.98 where a period is found
  double repeats = 0.0;  ///< repetitions within the moving part of the recording

  bool found() const { return seconds > 0.0; }
};

/// Period T of the positions, to a fraction of a sample: the first deep minimum of
///
///   d(T) = mean over time and moving joints of (q(t + T) - q(t))^2 / (2 var q)
///
/// where the worst fifth of the times is excluded (start-up, a stop at the end). d is 1 for
/// unrelated positions; a minimum counts below 0.02, which is a repeat to within a fifth of the
/// standard deviation. At least 1.4 periods are needed; the first 125 s are searched. The estimate
/// is refined on the 2nd, 4th, 8th, ... repeat, so that the error is about (tracking error / speed)
/// / repeats.
MotionPeriod detect_period(const Recording& recording);

}  // namespace veridyn
