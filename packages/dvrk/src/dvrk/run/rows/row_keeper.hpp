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
  static constexpr double kMostTouched = 5e8;  ///< [bytes]
  Recording rows_;
  std::atomic<Eigen::Index> count_{0};
};

/// Times at which the boards latched: by their own counter while reads follow each other, which a busy
/// machine does not disturb; by the link's clock after a gap. Another client that reads the boards restarts
/// their counter: time that is missing in many successive reads is added.
class LatchTime {
 public:
  /// @param seconds  since the previous latch, by the board. @returns [s] since the first call.
  double next(double now, double seconds) noexcept {
    const double passed = now - last_;
    if (!started_) {
      time_ = 0.0;
      start_ = now;
      started_ = true;
    } else {
      const bool stands = seconds < kStands && passed > kStands;
      if (stands) ++stood_still_;
      time_ += gap_ || stands || std::abs(seconds - passed) > kClocksDiffer ? passed : seconds;
      find_foreign_reads(now - start_ - time_);
    }
    last_ = now;
    gap_ = false;
    return time_;
  }
  void mark_gap() noexcept { gap_ = true; }
  /// Latches during which the boards' counter did not advance, timed by the link's clock.
  long stalled_latches() const { return stood_still_; }
  /// Number of missing intervals.
  long foreign_reads() const { return foreign_; }

 private:
  // `behind` is the delay of a cycle relative to the boards' time. Its minimum drifts slowly with the two
  // clocks; a lasting step is time that another client's read has removed.
  void find_foreign_reads(double behind) noexcept {
    if (behind - usual_ <= kStep) {
      steps_ = 0;
      usual_ += (behind < usual_ ? kFollowDown : kFollowUp) * (behind - usual_);
      return;
    }
    least_ = steps_ == 0 ? behind : std::min(least_, behind);
    if (++steps_ < kStays) return;
    time_ += least_ - usual_;
    ++foreign_;
    steps_ = 0;
  }

  static constexpr double kStands = 1e-6;  // [s] shortest time between two reads
  static constexpr double kClocksDiffer = 0.05;  // [s]
  static constexpr double kStep = 1e-4;          // [s]
  static constexpr int kStays = 8;               // reads in a row
  static constexpr double kFollowUp = 0.001, kFollowDown = 0.1;
  double time_ = 0.0, last_ = 0.0, start_ = 0.0, usual_ = 0.0, least_ = 0.0;
  int steps_ = 0;
  long foreign_ = 0, stood_still_ = 0;
  bool started_ = false, gap_ = false;
};

}  // namespace veridyn::dvrk
