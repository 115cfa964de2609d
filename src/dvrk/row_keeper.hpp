#pragma once

#include <cmath>

#include "veridyn/dvrk/arm_units.hpp"
#include "veridyn/recordings/recording.hpp"
#include "math/most_rows.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {

/// The rows of a recording. Room is made before the loop begins: keep() does not allocate.
class RowKeeper {
 public:
  /// @throws InvalidInput  more rows than the machine holds.
  RowKeeper(int joints, double seconds, double rate) {
    const double most_held = most_rows(1.0 + 4.0 * joints);
    require(kSpare * seconds * rate < most_held, "recording: found ", seconds, " s at ", rate,
            " Hz, expected fewer than ", std::floor(most_held / kSpare),
            " rows, what this machine holds.");
    const auto most = static_cast<Eigen::Index>(kSpare * seconds * rate) + 1000;
    rows_.time.resize(most);
    for (const RecordingSignal& signal : kRecordingSignals) {
      if (signal.values != &Recording::ddq) (rows_.*signal.values).resize(most, joints);
    }
  }

  void keep(double t, const ArmState& state) noexcept {
    if (count_ >= rows_.time.size() || (count_ > 0 && t <= rows_.time[count_ - 1])) return;
    rows_.time[count_] = t;
    rows_.q.row(count_) = state.q.transpose();
    rows_.dq.row(count_) = state.dq.transpose();
    rows_.tau.row(count_) = state.tau.transpose();
    rows_.current.row(count_) = state.current.transpose();
    ++count_;
  }

  Recording take(Eigen::Index joints) {
    Recording out;
    out.time = rows_.time.head(count_);
    out.q = rows_.q.topLeftCorner(count_, joints);
    out.dq = rows_.dq.topLeftCorner(count_, joints);
    out.tau = rows_.tau.topLeftCorner(count_, joints);
    return out;
  }

 private:
  static constexpr double kSpare = 1.2;  ///< of the rows that are expected
  Recording rows_;
  Eigen::Index count_ = 0;
};

/// Time of the instants at which the boards latched: their own counter where reads follow each
/// other, which no busy machine disturbs; the link's clock after a gap.
class LatchTime {
 public:
  /// @param seconds  since the latch before, as the board says. @returns [s] since the first call.
  double next(double now, double seconds) noexcept {
    const double passed = now - last_;
    if (!started_) {
      time_ = 0.0;
      started_ = true;
    } else {
      time_ += gap_ || std::abs(seconds - passed) > kClocksDiffer ? passed : seconds;
    }
    last_ = now;
    gap_ = false;
    return time_;
  }
  void lost() noexcept { gap_ = true; }

 private:
  static constexpr double kClocksDiffer = 0.05;  // [s]
  double time_ = 0.0, last_ = 0.0;
  bool started_ = false, gap_ = false;
};

}  // namespace veridyn::dvrk
