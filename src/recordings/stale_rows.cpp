#include "veridyn/recordings/stale_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "recordings/absurd.hpp"

namespace veridyn {
namespace {

constexpr double kLongest = 0.1;  // [s] largest time between the new values on either side

using Index = Eigen::Index;

bool repeats_row_before(const MatrixXd& m, Index k) {
  for (Index j = 0; j < m.cols(); ++j) {
    // The comparison is false for NaN, which never counts as repeated.
    if (!(m(k, j) == m(k - 1, j))) return false;
  }
  return true;
}

bool is_finite_row(const MatrixXd& m, Index k) {
  for (Index j = 0; j < m.cols(); ++j) {
    if (!(std::abs(m(k, j)) < kAbsurd)) return false;
  }
  return true;
}

// Rows that equal the previous one in every signal.
std::vector<Index> repeated_rows(const Recording& r) {
  std::vector<Index> out;
  for (Index k = 1; k < r.rows(); ++k) {
    const bool all =
        std::all_of(std::begin(kRecordingSignals), std::end(kRecordingSignals),
                    [&](const RecordingSignal& signal) { return repeats_row_before(r.*signal.values, k); });
    if (all) out.push_back(k);
  }
  return out;
}

// Monotone cubic at the share u between p0 and p1, with derivatives v0 and v1 with respect to u (Fritsch and
// Carlson, SIAM J. Numer. Anal. 17(2), 1980): a coarse or wrong velocity has little effect.
double monotone_cubic(double p0, double v0, double p1, double v1, double u) {
  const double left = 1.0 - u;
  const double steepest = 3.0 * (p1 - p0);
  v0 = std::clamp(v0, std::min(0.0, steepest), std::max(0.0, steepest));
  v1 = std::clamp(v1, std::min(0.0, steepest), std::max(0.0, steepest));
  return left * left * ((1.0 + 2.0 * u) * p0 + u * v0) + u * u * ((3.0 - 2.0 * u) * p1 - left * v1);
}

// Interpolates stale rows of a recording, beginning with row `first`.
class Filling {
 public:
  Filling(const Recording& raw, Index first, Recording& rows)
      : raw_(raw), first_(first), rows_(rows), age_(static_cast<size_t>(rows.rows()), 0.0) {}

  void run() {
    for (const Index stale : repeated_rows(raw_)) {
      for (const RecordingSignal& signal : kRecordingSignals) {
        if ((raw_.*signal.values).size() > 0) fill_around(stale, signal);
      }
    }
  }

  FilledRows filled() const {
    FilledRows out;
    for (const double age : age_) {
      out.count += age > 0.0 ? 1 : 0;
      out.age += age;
    }
    return out;
  }

 private:
  void fill_around(Index stale, const RecordingSignal& signal) {
    const MatrixXd& m = raw_.*signal.values;
    const auto near = [&](Index k) {
      return std::abs(raw_.time[k] - raw_.time[stale]) <= kLongest;
    };
    Index before = stale - 1;
    while (before > 0 && near(before) && repeats_row_before(m, before)) --before;
    Index after = stale + 1;
    while (after < raw_.rows() && near(after) && repeats_row_before(m, after)) ++after;
    if (after == raw_.rows() || raw_.time[after] - raw_.time[before] > kLongest) return;
    if (!is_finite_row(m, before) || !is_finite_row(m, after) || !is_moving_across(stale, before, after)) return;
    const Index begin = std::max(before + 1, first_);
    const Index end = std::min(after, first_ + static_cast<Index>(rows_.rows()));
    for (Index k = begin; k < end; ++k) interpolate(k, before, after, signal);
  }

  bool is_moving_across(Index stale, Index before, Index after) const {
    if (raw_.dq.size() > 0) return (raw_.dq.row(stale).array() != 0.0).any();
    return raw_.q.row(before) != raw_.q.row(after);
  }

  void interpolate(Index k, Index before, Index after, const RecordingSignal& signal) {
    const MatrixXd& m = raw_.*signal.values;
    const double age = raw_.time[k] - raw_.time[before];
    const double length = raw_.time[after] - raw_.time[before];
    const double u = age / length;
    MatrixXd& out = rows_.*signal.values;
    const Index row = k - first_;
    const bool curved = signal.values == &Recording::q && raw_.dq.size() > 0 &&
                        is_finite_row(raw_.dq, before) && is_finite_row(raw_.dq, after);
    for (Index j = 0; j < m.cols(); ++j) {
      out(row, j) = curved ? monotone_cubic(m(before, j), length * raw_.dq(before, j), m(after, j),
                                      length * raw_.dq(after, j), u)
                           : (1.0 - u) * m(before, j) + u * m(after, j);
    }
    double& oldest = age_[row];
    oldest = std::max(oldest, age);
  }

  const Recording& raw_;
  Index first_;
  Recording& rows_;
  std::vector<double> age_;  // [s] age of an interpolated row's data: that of its oldest signal
};

}  // namespace

std::string filled_text(const FilledRows& filled, long rows) {
  return fmt::format(
      "{:.2g} % of the rows repeated the row before, {:.1f} ms late on average, and are filled in",
      100.0 * static_cast<double>(filled.count) / static_cast<double>(rows),
      1e3 * filled.lateness());
}

SoundRows::SoundRows(Source source) : source_(std::move(source)) {}

// Number of held rows that will not change and have not been returned.
int SoundRows::settled_rows() const {
  if (held_.rows() == 0) return 0;
  int end = held_.rows();
  if (!ended_) {
    const double last = held_.time[end - 1];
    while (end > given_ && held_.time[end - 1] >= last - kLongest) --end;
  }
  return end - given_;
}

// Drops rows that are too old to affect the following ones.
void SoundRows::clear_position_history() {
  const double next = held_.time[std::min(given_, held_.rows() - 1)];
  int first = 0;
  while (first < given_ && held_.time[first] < next - kLongest) ++first;
  held_ = rows_of(held_, first, held_.rows() - first);
  given_ -= first;
}

Recording SoundRows::next(int rows) {
  while (!ended_ && settled_rows() < rows) {
    Recording more = source_(rows);
    ended_ = more.rows() == 0;
    if (!ended_) append(held_, std::move(more));
  }
  const int count = std::min(rows, settled_rows());
  if (count == 0) return {};
  Recording out = rows_of(held_, given_, count);
  Filling filling(held_, given_, out);
  filling.run();
  const FilledRows here = filling.filled();
  filled_.count += here.count;
  filled_.age += here.age;
  given_ += count;
  clear_position_history();
  return out;
}

}  // namespace veridyn
