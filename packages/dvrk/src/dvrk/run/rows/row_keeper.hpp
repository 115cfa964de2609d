#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>

#include "veridyn/math/most_rows.hpp"
#include "dvrk/arms/arm_units.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/recordings/recording.hpp"

namespace veridyn::dvrk {

/// The rows of a recording. Memory is allocated before the loop begins: keep() does not allocate. Another
/// thread may read the first count() rows meanwhile.
class RowKeeper {
 public:
  /// @throws InvalidInput  more rows than fit into the machine's memory.
  RowKeeper(int joints, double seconds, double rate) {
    const double most_held = most_rows(1.0 + 3.0 * joints);
    require(kSpare * seconds * rate < most_held, "recording: found ", seconds, " s at ", rate,
            " Hz, expected fewer than ", std::floor(most_held / kSpare),
            " rows, what this machine holds.");
    const auto most = static_cast<Eigen::Index>(kSpare * seconds * rate) + 1000;
    rows_.time.resize(most);
    for (MatrixXd* signal : {&rows_.q, &rows_.dq, &rows_.tau}) signal->resize(most, joints);
    // A page that is touched for the first time in the loop would stop it for a moment.
    if (3.0 * 8.0 * static_cast<double>(rows_.q.size()) > kMostTouched) return;
    rows_.time.setZero();
    for (MatrixXd* signal : {&rows_.q, &rows_.dq, &rows_.tau}) signal->setZero();
  }

  /// Appends a row at t [s]; does nothing if memory is full or t has not increased.
  void keep(double t, const BoardArmState& state) noexcept {
    const Eigen::Index row = count();
    if (row >= rows_.time.size() || (row > 0 && t <= rows_.time[row - 1])) return;
    rows_.time[row] = t;
    rows_.q.row(row) = state.q.transpose();
    rows_.dq.row(row) = state.dq.transpose();
    rows_.tau.row(row) = state.tau.transpose();
    count_.store(row + 1, std::memory_order_release);
  }

  const Recording& rows() const { return rows_; }
  Eigen::Index count() const { return count_.load(std::memory_order_acquire); }

  /// A copy of the rows kept until now, with the first `joints` joints.
  Recording extract_rows(Eigen::Index joints) const {
    const Eigen::Index rows = count();
    Recording out;
    out.time = rows_.time.head(rows);
    out.q = rows_.q.topLeftCorner(rows, joints);
    out.dq = rows_.dq.topLeftCorner(rows, joints);
    out.tau = rows_.tau.topLeftCorner(rows, joints);
    return out;
  }

 private:
  static constexpr double kSpare = 1.2;        ///< Factor on the expected number of rows
  static constexpr double kMostTouched = 5e8;  ///< [bytes] larger memory is not written in advance
  Recording rows_;
  std::atomic<Eigen::Index> count_{0};
};

/// Times at which the boards latched: by their own counter while reads follow each other, which a busy
/// machine does not disturb; by the link's clock after a gap. Another client that reads the boards restarts
/// their counter: time that is missing in many successive reads is added.
class LatchTime {
 public:
  /// @param now  [s] by the link's clock. @param seconds  since the previous latch, by the board. @returns [s] since the first call.
  double next(double now, double seconds) noexcept {
    const double passed = now - last_;
    if (!started_) {
      time_ = 0.0;
      start_ = now;
      started_ = true;
    } else {
      const bool is_stalled = seconds < kShortestInterval && passed > kShortestInterval;
      if (is_stalled) ++stalled_latches_;
      time_ += gap_ || is_stalled || std::abs(seconds - passed) > kLargestClockDifference ? passed : seconds;
      find_foreign_reads(now - start_ - time_);
    }
    last_ = now;
    gap_ = false;
    return time_;
  }
  void mark_gap() noexcept { gap_ = true; }  ///< the next interval is that of the link's clock
  /// Latches during which the boards' counter did not advance, timed by the link's clock.
  long stalled_latches() const { return stalled_latches_; }
  /// Number of intervals that reads of another client have removed.
  long foreign_reads() const { return foreign_; }

 private:
  // `behind` is the delay of a cycle relative to the boards' time. Its minimum drifts slowly with the two
  // clocks; a lasting increase is time that another client's read has removed.
  void find_foreign_reads(double behind) noexcept {
    if (behind - baseline_delay_ <= kLastingDelay) {
      delayed_reads_ = 0;
      baseline_delay_ += (behind < baseline_delay_ ? kFollowDown : kFollowUp) * (behind - baseline_delay_);
      return;
    }
    smallest_delay_ = delayed_reads_ == 0 ? behind : std::min(smallest_delay_, behind);
    if (++delayed_reads_ < kLastingReads) return;
    time_ += smallest_delay_ - baseline_delay_;
    ++foreign_;
    delayed_reads_ = 0;
  }

  // [s] interval of the boards below this, while the link's clock exceeds it: their counter is stalled
  static constexpr double kShortestInterval = 1e-6;
  // [s] difference between the two clocks' intervals above this: the link's clock is used
  static constexpr double kLargestClockDifference = 0.05;
  // [s] delay above the baseline by more than this in kLastingReads successive reads: another client has read
  static constexpr double kLastingDelay = 1e-4;
  static constexpr int kLastingReads = 8;
  // shares by which the baseline follows larger and smaller delays
  static constexpr double kFollowUp = 0.001, kFollowDown = 0.1;
  double time_ = 0.0, last_ = 0.0, start_ = 0.0;
  double baseline_delay_ = 0.0;  // [s] usual delay of a cycle relative to the boards' time
  double smallest_delay_ = 0.0;  // [s] smallest delay of the present series of delayed reads
  int delayed_reads_ = 0;
  long foreign_ = 0, stalled_latches_ = 0;
  bool started_ = false, gap_ = false;
};

}  // namespace veridyn::dvrk
