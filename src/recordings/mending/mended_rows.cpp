#include "recordings/mending/mended_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "math/median.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::recordings {
namespace {

constexpr double kGap = std::numeric_limits<double>::quiet_NaN();
/// rows read before the first one is returned >= kFirstRows: they determine the clock and the scales.
constexpr int kFirstRows = 8192;
/// first rows < kFewestRows: too few for the usual range of a signal; angles, dropouts and bursts are not
/// corrected.
constexpr int kFewestRows = 50;
/// previous rows that stay in memory = kContext.
constexpr int kContext = 8;
/// A dropout of at most kLongestDropout [s], and of kFewRows to kManyRows rows, is repaired; longer ones are not.
constexpr double kLongestDropout = 1.0;
constexpr int kFewRows = 8, kManyRows = 4096;
/// step < kWithin * mean step in a share of the steps >= kBurstShare: rows come in bursts of two and more.
/// Clocks of 120 to 160 Hz have no such steps, and late publishers repeat rows without them.
constexpr double kWithin = 0.25, kBurstShare = 0.48;
/// time between bursts > kHole * the usual time: rows are missing before the burst.
constexpr double kHole = 2.5;
/// |jump - turn| < kOfTurn * turn + kAround * the previous step: the angle is wrapped.
constexpr double kOfTurn = 0.05;
/// positions farther than kBeyond * range outside of the limits are impossible.
constexpr double kBeyond = 0.05;
/// step > the largest of kSmallestJump, kNoise * usual second difference and kOfRange * range, plus kAround *
/// the neighbouring steps: a jump. The check of jumps has the same numbers (QualityNumbers).
constexpr double kSmallestJump = 2e-3, kNoise = 5.0, kOfRange = 0.02, kAround = 4.0;
/// torque outside of its usual range by > kSpike of that range, or farther than the whole range from the rows beside: a spike;
/// several rows: each differs from the one before by > kSpike of that range.
constexpr double kSpike = 0.5;
/// |position| > kFar [rad, m]: not close to zero.
constexpr double kFar = 0.05;
/// Quantile that defines the usual range, so that single wrong values do not count.
constexpr double kUsual = 0.98;

const double kPi = std::acos(-1.0);

double quantile(std::vector<double> values, double share) {
  values.erase(std::remove_if(values.begin(), values.end(), [](double v) { return !std::isfinite(v); }), values.end());
  if (values.empty()) return 0.0;
  const auto at = values.begin() + static_cast<long>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

std::string count_text(long count, const char* one, const char* many) { return text(count, " ", count == 1 ? one : many); }

class MendedRows : public RowSource {
 public:
  MendedRows(std::unique_ptr<RowSource> rows, const SignalChoice& choice)
      : rows_(std::move(rows)), choice_(choice), joints_(static_cast<std::size_t>(rows_->joints())) {}

  int joints() const override { return rows_->joints(); }

  Recording next(int rows) override {
    if (!begun_) {
      while (held_.rows() < kFirstRows && read_on()) {
      }
      begun_ = true;
      if (held_.rows() > 0) inspect_first_rows();
    }
    const auto ready = [this] { return choice_.as_recorded || ended_ ? held_.rows() : std::min(sound_, timed_); };
    while (true) {
      if (few_ && !choice_.as_recorded) {
        spread_equal_times(timed_, held_.rows());
        sound_ = held_.rows();
      } else if (!choice_.as_recorded) {
        find_frozen(unwrapped_);
        unwrap(unwrapped_);
        bursts_ ? spread_bursts() : spread_equal_times(timed_, held_.rows());
        find_zeros(ended_ ? held_.rows() : held_.rows() - ahead_);
        find_spikes(ended_ ? held_.rows() : held_.rows() - ahead_);
        find_dropouts(ended_ ? held_.rows() : held_.rows() - ahead_);
      }
      if (ready() - given_ >= rows || ended_) break;
      read_on();
    }
    const int count = std::min(rows, ready() - given_);
    Recording out = rows_of(held_, given_, count);
    given_ += count;
    const int old = std::max(0, given_ - kContext);
    held_ = rows_of(held_, old, held_.rows() - old);
    for (int* at : {&given_, &unwrapped_, &timed_, &sound_}) *at = std::max(0, *at - old);
    return out;
  }

  RecordingFacts facts() const override {
    RecordingFacts out = rows_->facts();
    const auto add = [&out](long count, const std::string& remark) {
      if (count > 0) out.remarks.push_back(remark);
    };
    const auto named = [this](const char* signal, std::size_t j) {
      return text(signal, j + 1, j < choice_.joints.size() ? " (" + choice_.joints[j].name + ")" : "");
    };
    add(foreign_, text(count_text(foreign_, "row", "rows"), " of zeros alone amid the motion, as of another publisher, ",
                       foreign_ == 1 ? "is" : "are", " left out (--as-recorded keeps them)."));
    add(repeated_, text(count_text(repeated_, "row repeats", "rows repeat"), " the time stamp before and ", repeated_ == 1 ? "is" : "are", " left out."));
    add(equal_, text(count_text(equal_, "row repeats", "rows repeat"),
                     " the time stamp before with other values: such rows are spread evenly up to the next time."));
    add(in_bursts_, text(in_bursts_, " rows came in bursts and were stamped at arrival: they are spread evenly since the burst before "
                                     "(--as-recorded keeps their times)."));
    for (std::size_t j = 0; j < joints_.size(); ++j)
      add(joints_[j].wraps, text(named("q", j), " is wrapped ", count_text(joints_[j].wraps, "time", "times"),
                               " and is continued over whole turns (--as-recorded keeps it)."));
    for (std::size_t j = 0; j < joints_.size(); ++j)
      add(joints_[j].frozen, text("q", j + 1, " and ", named("dq", j), " stay the same in ", count_text(joints_[j].frozen, "row", "rows"),
                                  ", although the joint moves with this velocity or the one before: its encoder does not answer, "
                                "and the rows are gaps (--as-recorded keeps them)."));
    add(dropouts_, text("positions leave the motion and come back ", count_text(dropouts_, "time", "times"), ": ", count_text(dropped_, "row is", "rows are"),
                        held_.dq.cols() > 0 ? " filled in by the velocities before and behind" : " left out", " (--as-recorded keeps them)."));
    for (std::size_t j = 0; j < joints_.size(); ++j)
      add(joints_[j].spikes, text(named("tau", j), " jumps out of its range in ", count_text(joints_[j].spikes, "row", "rows"),
                                  ": filled in from the rows beside (--as-recorded keeps it)."));
    add(zeros_, text("all torques drop to zero amid the motion in ",
                     count_text(zeros_, "row, which is a gap", "rows, which are gaps"), " (--as-recorded keeps them)."));
    return out;
  }

 private:
  // Properties of one joint's position, as far as known.
  struct Joint {
    double turn = 2.0 * kPi;  // length of a turn in the unit of the file, if no unit is declared
    double turns = 0.0;       // offset for the following rows
    double jump = HUGE_VAL;   // smallest step that motion does not explain
    long wraps = 0;
    double lowest = -HUGE_VAL, highest = HUGE_VAL;  // usual range of the torque, spikes excluded
    long spikes = 0;
    double q = kGap, dq = kGap;  // last position and velocity, as in the file
    double speed = 0.0;          // |dq| of that row, or of the row before if dq dropped more than `drop`
    double drop = HUGE_VAL;      // largest usual change of the velocity from row to row, times kNoise
    int held = 0;                // rows with this same q and dq in which the torques changed
    long frozen = 0;             // rows that became gaps because the encoder had stopped answering
  };

  bool read_on() {
    Recording piece = rows_->next(std::max(kFirstRows, ahead_));
    ended_ = piece.rows() == 0;
    if (ended_) return false;
    leave_out(piece);
    append(held_, std::move(piece));
    return true;
  }

  // Determines the scales of steps, the behaviour of the clock, and the length of a turn for joints with
  // wrapped angles.
  void inspect_first_rows() {
    const int n = held_.rows();
    few_ = n < kFewestRows;
    if (n > 1) step_ = (held_.time[n - 1] - held_.time[0]) / (n - 1);
    if (choice_.as_recorded || few_) return;
    if (step_ > 0.0) ahead_ = std::clamp(static_cast<int>(kLongestDropout / step_), kFewRows, kManyRows);
    long within = 0;
    std::vector<double> between;
    double last = held_.time[0];
    for (int k = 1; k < n; ++k) {
      const bool inside = held_.time[k] - held_.time[k - 1] < kWithin * step_;
      within += inside && held_.time[k] > held_.time[k - 1] ? 1 : 0;
      if (!inside) between.push_back(held_.time[k] - std::exchange(last, held_.time[k]));
    }
    bursts_ = static_cast<double>(within) >= kBurstShare * (n - 1) && between.size() > kFewRows;
    burst_step_ = median(std::move(between));
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      const auto q = held_.q.col(static_cast<Eigen::Index>(j));
      std::vector<double> all(q.data(), q.data() + n), change;
      for (int k = 2; k < n; ++k) change.push_back(std::abs(q[k] - 2.0 * q[k - 1] + q[k - 2]));
      const double range = quantile(all, kUsual) - quantile(all, 1.0 - kUsual);
      joints_[j].jump = std::max({kSmallestJump, kNoise * quantile(std::move(change), kUsual), kOfRange * range});
      if (range > 4.0 * kPi) joints_[j].turn = 360.0;  // undeclared degrees
      change.clear();
      for (int k = 1; k < n && held_.dq.cols() > 0; ++k) change.push_back(std::abs(held_.dq(k, static_cast<Eigen::Index>(j)) - held_.dq(k - 1, static_cast<Eigen::Index>(j))));
      if (!change.empty()) joints_[j].drop = kNoise * quantile(std::move(change), kUsual);
      if (held_.tau.cols() == 0) continue;
      const auto tau = held_.tau.col(static_cast<Eigen::Index>(j));
      const std::vector<double> torques(tau.data(), tau.data() + n);
      const double low = quantile(torques, 1.0 - kUsual), high = quantile(torques, kUsual);
      if (!(high > low)) continue;
      joints_[j].lowest = low - kSpike * (high - low);
      joints_[j].highest = high + kSpike * (high - low);
    }
    find_frozen(0);
    unwrap(0);
    start_within_limits();
  }

  // Drops rows of another publisher; with as_recorded those that repeat a time.
  void leave_out(Recording& piece) {
    int kept = 0;
    for (int k = 0; k < piece.rows(); ++k) {
      const Recording& before = kept > 0 ? piece : held_;
      const int last = kept > 0 ? kept - 1 : held_.rows() - 1;
      const bool repeats = choice_.as_recorded && last >= 0 && piece.time[k] == before.time[last];
      const bool foreign = is_isolated_zero_row(piece, k, before, last);
      repeated_ += repeats ? 1 : 0;
      foreign_ += foreign ? 1 : 0;
      if (repeats || foreign) continue;
      if (kept < k) {
        piece.time[kept] = piece.time[k];
        for (const RecordingSignal& signal : kRecordingSignals) {
          MatrixXd& values = piece.*signal.values;
          if (values.cols() > 0) values.row(kept) = values.row(k).eval();
        }
      }
      ++kept;
    }
    if (kept < piece.rows()) piece = rows_of(piece, 0, kept);
  }

  // True for a row of zeros between positions that are not close to zero.
  bool is_isolated_zero_row(const Recording& piece, int k, const Recording& before, int last) const {
    if (choice_.as_recorded || last < 0 || !(before.q.row(last).cwiseAbs().maxCoeff() > kFar)) return false;
    const bool last_one = k + 1 == piece.rows();
    if (last_one ? piece.tau.cols() == 0 && piece.dq.cols() == 0 : !(piece.q.row(k + 1).cwiseAbs().maxCoeff() > kFar)) return false;
    return std::all_of(std::begin(kRecordingSignals), std::end(kRecordingSignals), [&](const RecordingSignal& signal) {
      return (piece.*signal.values).cols() == 0 || ((piece.*signal.values).row(k).array() == 0.0).all();
    });
  }

  // Spreads rows with equal times and different values up to the next time: the resolution of the clock was too
  // low.
  void spread_equal_times(int from, int to) {
    auto& t = held_.time;
    int k = std::max(1, from);
    while (k < to) {
      if (t[k] > t[k - 1]) {
        timed_ = ++k;
        continue;
      }
      int end = k;
      while (end < to && t[end] <= t[k - 1]) ++end;
      if (end == to && !ended_) return;
      const double room = end < to ? t[end] - t[k - 1] : step_ * (end - k + 1);
      const double start = t[k - 1];
      for (int i = k; i < end; ++i) t[i] = start + room * (i - k + 1) / (end - k + 1);
      equal_ += end - k;
      timed_ = k = end;
    }
    timed_ = to;
  }

  // Spreads the rows of a burst: the last one was measured on arrival, the others since the previous burst.
  void spread_bursts() {
    auto& t = held_.time;
    const int n = held_.rows();
    const double short_step = kWithin * step_;
    while (timed_ < n) {
      int end = timed_ + 1;
      while (end < n && t[end] - t[end - 1] < short_step) ++end;
      if (end == n && !ended_) return;
      const double arrived = t[end - 1];
      double room = std::min(arrived - burst_before_, kHole * burst_step_);
      if (!(room > 0.0) || room == kHole * burst_step_) room = burst_step_;
      const int count = end - timed_;
      for (int i = timed_; i < end; ++i) t[i] = arrived - room * (end - 1 - i) / count;
      burst_before_ = arrived;
      in_bursts_ += count > 1 ? count : 0;
      timed_ = end;
    }
  }

  // Makes gaps of rows in which an encoder stopped answering: position and velocity of a joint repeat to the
  // last digit while torques change, and the last velocity would have moved the joint farther than the steps
  // that motion explains. If that velocity had just dropped faster than the joint brakes, the one before
  // counts.
  void find_frozen(int from) {
    const MatrixXd& torque = held_.tau.cols() > 0 ? held_.tau : held_.current;
    for (std::size_t j = 0; j < joints_.size() && held_.dq.cols() > 0 && torque.cols() > 0; ++j) {
      Joint& joint = joints_[j];
      auto q = held_.q.col(static_cast<Eigen::Index>(j));
      const auto dq = held_.dq.col(static_cast<Eigen::Index>(j));
      for (int k = std::max(from, 1); k < held_.rows(); ++k) {
        if (q[k] != joint.q || dq[k] != joint.dq) {
          joint.q = q[k];
          joint.dq = dq[k];
          joint.speed = std::abs(dq[k] - dq[k - 1]) > joint.drop ? std::abs(dq[k - 1]) : std::abs(dq[k]);
          joint.held = 0;
          continue;
        }
        joint.held += torque.row(k) != torque.row(k - 1) ? 1 : 0;
        if (joint.held < kFewRows || joint.held * step_ * joint.speed < joint.jump) continue;
        q[k] = kGap;
        ++joint.frozen;
        for (int m = k - 1; m >= std::max(given_, 1) && q[m] == joint.q && q[m - 1] == joint.q; --m) {
          q[m] = kGap;
          ++joint.frozen;
        }
      }
    }
  }

  // Adds whole turns after an angle has wrapped: the rest of the jump is as small as the previous step allows.
  void unwrap(int from) {
    const int n = held_.rows();
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      Joint& joint = joints_[j];
      if (j < choice_.joints.size() && choice_.joints[j].prismatic) continue;
      auto q = held_.q.col(static_cast<Eigen::Index>(j));
      for (int k = from; k < n; ++k) {
        q[k] += joint.turns * joint.turn;
        if (k < 2 || !std::isfinite(q[k] - q[k - 1])) continue;
        const double jump = q[k] - q[k - 1];
        const double turns = std::round(jump / joint.turn);
        if (turns == 0.0 || std::abs(turns) > 1.0) continue;
        const double before = std::abs(q[k - 1] - q[k - 2]);
        if (!(std::abs(jump - turns * joint.turn) < kOfTurn * joint.turn + kAround * before) || !(before < kOfTurn * joint.turn)) continue;
        q[k] -= turns * joint.turn;
        joint.turns -= turns;
        ++joint.wraps;
      }
    }
    unwrapped_ = n;
  }

  // Shifts wrapped angles by whole turns into the joint's limits, since an encoder may count from another turn.
  void start_within_limits() {
    const bool wrapped = std::any_of(joints_.begin(), joints_.end(), [](const Joint& joint) { return joint.wraps > 0; });
    for (std::size_t j = 0; j < joints_.size() && j < choice_.joints.size(); ++j) {
      const WantedJoint& wanted = choice_.joints[j];
      Joint& joint = joints_[j];
      if (!wrapped || wanted.prismatic || !std::isfinite(wanted.upper - wanted.lower)) continue;
      auto q = held_.q.col(static_cast<Eigen::Index>(j));
      const double unit = joint.turn / (2.0 * kPi);
      const double margin = kBeyond * (wanted.upper - wanted.lower);
      std::vector<double> all(q.data(), q.data() + q.size());
      const double middle = 0.5 * (quantile(all, kUsual) + quantile(all, 1.0 - kUsual));
      const double shift = std::round((0.5 * (wanted.lower + wanted.upper) * unit - middle) / joint.turn);
      const auto inside = [&](double by) {
        return quantile(all, kUsual) + by <= (wanted.upper + margin) * unit && quantile(all, 1.0 - kUsual) + by >= (wanted.lower - margin) * unit;
      };
      if (inside(0.0) || !inside(shift * joint.turn)) continue;
      q.array() += shift * joint.turn;
      joint.turns += shift;
    }
  }

  void find_dropouts(int until) {
    int k = std::max(sound_, 1);
    if (sound_ == 0 && held_.rows() > 2 && (held_.q.row(0).array() == 0.0).all() && !is_explained_by_next()) {
      held_.q.row(0).setConstant(kGap);  // a row of another publisher
      ++dropped_;
      ++dropouts_;
    }
    for (; k < until; ++k) {
      if (continues(k - 1, k)) continue;
      const int back = row_of_return(k - 1, k);
      if (back < 0) continue;
      fill(k - 1, back);
      dropped_ += back - k;
      ++dropouts_;
      // The next row is compared with the last valid one, because rows of a gap have no position.
      k = back;
    }
    sound_ = std::max(sound_, std::min(k, held_.rows()));
  }

  // Fills positions between two valid rows by the cubic through both with their velocities; gaps without
  // velocities.
  void fill(int before, int after) {
    const double length = held_.time[after] - held_.time[before];
    for (int k = before + 1; k < after; ++k) {
      if (held_.dq.cols() == 0) {
        held_.q.row(k).setConstant(kGap);
        continue;
      }
      const double u = (held_.time[k] - held_.time[before]) / length, left = 1.0 - u;
      held_.q.row(k) = left * left * ((1.0 + 2.0 * u) * held_.q.row(before) + u * length * held_.dq.row(before)) +
                       u * u * ((3.0 - 2.0 * u) * held_.q.row(after) - left * length * held_.dq.row(after));
    }
  }

  // The first row after `away` that continues the motion of row `last`, after every joint that had jumped has
  // jumped back; -1 if there is none. After lost rows, joints do not jump back.
  int row_of_return(int last, int away) const {
    const int end = std::min(held_.rows(), away + ahead_);
    std::vector<int> gone;
    for (int j = 0; j < joints(); ++j) {
      if (is_jump(last, away, j)) gone.push_back(j);
    }
    for (int m = away + 1; m < end; ++m) {
      const auto comes_back = [&](int j) {
        const double step = held_.q(m, j) - held_.q(m - 1, j);
        return std::abs(step) > reach(last, 1, j) && step * (held_.q(away, j) - held_.q(last, j)) < 0.0;
      };
      gone.erase(std::remove_if(gone.begin(), gone.end(), comes_back), gone.end());
      if (gone.empty() && continues(last, m)) return m;
    }
    return -1;
  }

  bool is_jump(int last, int k, int joint) const {
    return std::abs(held_.q(k, joint) - held_.q(last, joint)) > reach(last, k - last, joint);
  }

  // True if no joint jumps from row `last` to row k.
  bool continues(int last, int k) const {
    for (int j = 0; j < joints(); ++j) {
      if (is_jump(last, k, j)) return false;
    }
    return true;
  }

  // True if the second row explains the step into the first one.
  bool is_explained_by_next() const {
    for (int j = 0; j < joints(); ++j) {
      const double second = std::abs(held_.q(2, j) - held_.q(1, j));
      if (std::abs(held_.q(1, j) - held_.q(0, j)) > joints_[static_cast<std::size_t>(j)].jump + kAround * second) return false;
    }
    return true;
  }

  // Largest possible displacement of a joint within some rows after a valid one.
  double reach(int last, int rows, int joint) const {
    double fastest = 0.0;
    for (int k = std::max(1, last - 2); k <= last; ++k) {
      const double step = std::abs(held_.q(k, joint) - held_.q(k - 1, joint));
      if (std::isfinite(step)) fastest = std::max(fastest, step);
    }
    if (held_.dq.cols() > 0 && std::isfinite(held_.dq(last, joint))) fastest = std::max(fastest, step_ * std::abs(held_.dq(last, joint)));
    return joints_[static_cast<std::size_t>(joint)].jump + kAround * fastest * rows;
  }

  // Finds torques that are exactly zero on all joints for a time, between values of one sign of a joint that
  // are not close to zero.
  void find_zeros(int until) {
    for (MatrixXd* values : {&held_.tau, &held_.current}) {
      if (values->cols() == 0) continue;
      MatrixXd& v = *values;
      const auto zero = [&v](int k) { return (v.row(k).array() == 0.0).all(); };
      for (int k = std::max(sound_, 2); k < until; ++k) {
        if (!zero(k) || zero(k - 1)) continue;
        int end = k + 1;
        while (end < held_.rows() && end < k + ahead_ && zero(end)) ++end;
        if (end + 1 >= held_.rows() || zero(end)) continue;
        bool far = false;
        for (Eigen::Index j = 0; j < v.cols(); ++j) {
          const double around = std::max(std::abs(v(k - 1, j) - v(k - 2, j)), std::abs(v(end + 1, j) - v(end, j)));
          far = far || (v(k - 1, j) * v(end, j) > 0.0 && std::min(std::abs(v(k - 1, j)), std::abs(v(end, j))) > 2.0 * kAround * around);
        }
        if (!far) continue;
        v.middleRows(k, end - k).setConstant(kGap);
        zeros_ += end - k;
      }
    }
  }

  // Finds a torque outside of its usual range in a single row between usual ones.
  void find_spikes(int until) {
    for (std::size_t j = 0; j < joints_.size() && held_.tau.cols() > 0; ++j) {
      Joint& joint = joints_[j];
      auto tau = held_.tau.col(static_cast<Eigen::Index>(j));
      const auto usual = [&](int k) { return tau[k] >= joint.lowest && tau[k] <= joint.highest; };
      const double range = (joint.highest - joint.lowest) / (1.0 + 2.0 * kSpike);
      const auto is_off = [&](int k, int beside) { return !usual(k) || std::abs(tau[k] - tau[beside]) > range; };
      for (int k = std::max(sound_, 1); k + 1 < held_.rows() && k < until; ++k) {
        if (!std::isfinite(tau[k]) || !usual(k - 1) || !is_off(k, k - 1)) continue;
        int end = k + 1;
        while (end < held_.rows() && is_off(end, k - 1) && std::abs(tau[end] - tau[end - 1]) > kSpike * range) ++end;
        if (end == held_.rows() || is_off(end, k - 1) || !is_off(end - 1, end)) continue;
        for (int i = k; i < end; ++i, ++joint.spikes) tau[i] = tau[i - 1] + (tau[end] - tau[i - 1]) / (end - i + 1);
      }
    }
  }

  std::unique_ptr<RowSource> rows_;
  SignalChoice choice_;
  std::vector<Joint> joints_;
  Recording held_;
  int given_ = 0;     // number of held rows that have been returned
  int unwrapped_ = 0, timed_ = 0, sound_ = 0;  // number of held rows that each step has processed
  int ahead_ = kFewRows;
  bool ended_ = false, begun_ = false, bursts_ = false, few_ = false;
  double step_ = 0.0;         // [s] mean time step
  double burst_step_ = 0.0;   // [s] usual time between bursts
  double burst_before_ = kGap;
  long in_bursts_ = 0, equal_ = 0, repeated_ = 0, dropouts_ = 0, dropped_ = 0, zeros_ = 0, foreign_ = 0;
};

}  // namespace

std::unique_ptr<RowSource> mended(std::unique_ptr<RowSource> rows, const SignalChoice& choice) {
  return std::make_unique<MendedRows>(std::move(rows), choice);
}

}  // namespace veridyn::recordings
