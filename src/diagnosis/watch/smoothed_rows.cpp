#include "diagnosis/watch/smoothed_rows.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "math/median.hpp"
#include "math/decompositions.hpp"
#include "math/numbers.hpp"
#include "recordings/absurd.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::watching {
namespace {

constexpr const char* kContradiction = "positions and velocities contradict each other";

// Row d of the result gives the d-th derivative (in samples) at the middle of 2 half + 1 samples.
MatrixXd local_polynomial(int half, int degree) {
  const int count = 2 * half + 1;
  MatrixXd powers(count, degree + 1);
  VectorXd weight(count);
  for (int i = 0; i < count; ++i) {
    const double x = i - half;
    weight[i] = std::pow(std::cos(M_PI * x / (2.0 * half + 2.0)), 2);
    for (int p = 0; p <= degree; ++p) powers(i, p) = std::pow(x / half, p);
  }
  const MatrixXd weighted = weight.asDiagonal() * powers;
  MatrixXd kernel = (powers.transpose() * weighted).ldlt().solve(weighted.transpose());
  double factor = 1.0;
  for (int p = 1; p <= degree; ++p) {
    factor *= p / static_cast<double>(half);
    kernel.row(p) *= factor;
  }
  return kernel;
}

}  // namespace

SmoothedRows::SmoothedRows(const Model& arm, const WatchNumbers& numbers)
    : numbers_(numbers), arm_(arm), n_(arm.joints()), sensors_(arm), held_(arm_, numbers), last_jump_(VectorXd::Constant(arm.joints(), -kInfinity)),
      wait_(static_cast<size_t>(arm.joints()), 0) {
  for (VectorXd* v : {&offset_, &spread2_, &largest_, &moved2_, &excess_, &torque2_, &path_, &speed_, &mean_speed_, &fastest_}) *v = VectorXd::Zero(n_);
}

void SmoothedRows::check(const Recording& rows) const {
  const int n = arm_.joints();
  require(rows.joints() == n, rows.source, ": found ", rows.joints(), " joints, but robot '",
          arm_.name(), "' has ", n, " coordinates.");
  require(!has_velocity_ || rows.dq.size() > 0, rows.source, ": found no velocities (dq1..dq", n, "), expected them as in the rows before.");
  if (rows.tau.size() > 0) return;
  require(rows.current.size() > 0, rows.source, ": found neither torques (tau1..tau", n,
          ") nor motor currents (i1..i", n, ").");
  sensors_.require_drive_gains(arm_, rows.source);
}

// Reason why a row is unusable, or empty.
std::string SmoothedRows::row_fault(const Row& row) const {
  for (Eigen::Index i = 0; i < row.x.size(); ++i) {
    const double value = row.x[i];
    if (std::isfinite(value) && std::abs(value) < kAbsurd) continue;
    const char* signal[] = {"q", "dq", "tau"};
    const std::string found = std::isfinite(value) ? " is " + text(value) : " is no number";
    return text(signal[i / n_], i % n_ + 1, " (", arm_.coordinates()[i % n_].name, ")", found);
  }
  if (!arm_.gravity().isZero(0.0) && (row.x.tail(n_).array().square() <= numbers_.no_torque * numbers_.no_torque * torque2_.array()).all())
    return "the torques of all joints are zero: no drive is on, or none is recorded";
  return "";
}

// True if the arm moved when the last row came: one that repeats it is no rest.
bool SmoothedRows::was_moving() const {
  return (speed_.cwiseAbs().cwiseMin(mean_speed_.cwiseAbs()).array() > numbers_.rest_share * fastest_.array()).any();
}

void SmoothedRows::mark_unusable(double time, const std::string& why) {
  last_row_time_ = time;
  if (!has_row_) usable_ = time;  // unusable from the first row on
  has_row_ = true;
  if (is_blind_ || time - usable_ <= numbers_.pause) return;
  is_blind_ = true;
  if (on_blind && !was_blind_) on_blind({usable_, time, why});
  was_blind_ = true;
}

// False for a row whose time does not rise, until the clock is known to have been set back, as by the start
// of another controller.
bool SmoothedRows::is_clock_continuous(double time) {
  if (!last_ || time > last_->t) {
    // Set back by less, it has caught up: rows on both sides are not contiguous.
    if (back_ > 0 && back_last_ - back_first_ >= numbers_.jump_reach) restart();
    back_ = 0;
    return true;
  }
  if (back_ == 0 || time <= back_last_) back_first_ = time;
  back_last_ = time;
  const double before = usable_ + dt_ * static_cast<double>(++back_);  // by the clock as it was
  if (time - back_first_ >= 0.5 * numbers_.pause) {
    restart_clock(time, before);
    return true;
  }
  mark_unusable(before, "times do not rise");
  return false;
}

void SmoothedRows::restart_clock(double time, double before) {
  const double by = last_->t + dt_ - back_first_;
  blind_ += before - usable_;
  is_blind_ = false;
  if (on_blind) on_blind({usable_, before, text("the clock was set back to ", clock_.recorded_time(back_first_), " s, and the watch begins anew"), by});
  held_.set_back(by);
  path_time_ -= by;
  back_ = 0;
  usable_ = last_row_time_ = time;
  restart();
}

void SmoothedRows::mark_usable(double time) {
  if (is_blind_) {
    blind_ += time - usable_;
    is_blind_ = false;
  }
  usable_ = last_row_time_ = time;
  has_row_ = true;
}

void SmoothedRows::copy_row(const Recording& rows, int k, Row& row) const {
  row.t = clock_.true_time(rows.time[k]);
  VectorXd q = rows.q.row(k).transpose();
  const bool torques = rows.tau.size() > 0;
  VectorXd tau = (torques ? rows.tau : rows.current).row(k).transpose();
  sensors_.correct_positions(q);
  torques ? sensors_.correct_torques(tau) : sensors_.correct_currents(tau);
  row.x = VectorXd::Zero(3 * n_);
  row.x.head(n_) = q;
  if (has_velocity_) row.x.segment(n_, n_) = rows.dq.row(k).transpose();
  row.x.tail(n_) = tau;
}

void SmoothedRows::add(const Recording& rows) {
  if (rows.rows() == 0) return;
  check(rows);
  if (dt_ == 0.0 && start_.empty()) has_velocity_ = rows.dq.size() > 0;
  Row row;
  for (int k = 0; k < rows.rows(); ++k) {
    copy_row(rows, k, row);
    if (!std::isfinite(row.t)) continue;
    if (dt_ > 0.0) {
      accept(row);
      continue;
    }
    start_.push_back(row);
    const bool enough = k + 1 == rows.rows() || row.t - start_.front().t > kStart * numbers_.pause;
    if (!enough || start_.size() < static_cast<size_t>(numbers_.rows_for_step)) continue;
    choose_windows();
    require(dt_ > 0.0, rows.source, ": found times that do not rise, expected a clock.");
    for (const Row& one : std::exchange(start_, {})) accept(one);
  }
}

void SmoothedRows::accept(const Row& row) {
  if (!is_clock_continuous(row.t)) return;
  const std::string why = row_fault(row);
  why.empty() ? queue(row) : mark_unusable(row.t, why);
}

// The time step is that of the rows; the window of the smoothing holds some new values of each position and velocity.
void SmoothedRows::choose_windows() {
  std::vector<double> times;
  for (const Row& one : start_) {
    if (static_cast<int>(times.size()) < numbers_.rows_for_step) times.push_back(one.t);
  }
  dt_ = median_step(times);
  if (!(dt_ > 0.0)) return;
  const double refreshed = HeldSignals::refresh_time(start_, 2 * n_, numbers_.held);
  spacing_ = HeldSignals::refresh_time(start_, 3 * n_, numbers_.held);
  const double wide = std::max(has_velocity_ ? numbers_.half_window : numbers_.half_window_of_position, kHalfWindow * refreshed);
  // Between slow refreshes noise matters less than the shape of the motion; and without velocities they look like jumps.
  const bool slow = kHalfWindow * refreshed >= wide;
  sees_jumps_ = has_velocity_ || !slow;
  half_ = std::max(Eigen::Index{3}, static_cast<Eigen::Index>(std::lround(wide / dt_)));
  reach_ = std::clamp(static_cast<Eigen::Index>(std::lround(numbers_.jump_reach / dt_)), Eigen::Index{2}, half_ - 1);
  kernel_ = local_polynomial(static_cast<int>(half_), (has_velocity_ ? 2 : 3) + (slow ? 1 : 0)).topRows(3).transpose();
  kernel_.col(1) /= dt_;
  kernel_.col(2) /= dt_ * dt_;
  window_ = MatrixXd::Zero(3 * n_, 2 * half_ + 1);
}

// A signal that stopped, or positions and velocities that contradict each other; or empty.
std::string SmoothedRows::signal_fault(const Row& row) {
  VectorXd path = VectorXd::Zero(3 * n_);
  path.head(n_) = path_;
  path.tail(n_) = row.x.head(n_);
  const auto stopped = held_.compare(row, path, fastest_, is_blind_ ? std::nullopt : std::optional(usable_));
  if (!stopped) return contradiction_;
  usable_ = std::min(usable_, stopped->since);
  return stopped->why;
}

void SmoothedRows::queue(const Row& row) {
  // The smoothing's window holds so few rows that the lines between them have other derivatives.
  const double apart = row.t - std::exchange(placed_, row.t);
  std::string sparse;
  if (2.0 * apart > static_cast<double>(half_) * dt_ && apart <= numbers_.pause)
    sparse = text("rows come every ", std::round(1e4 * apart) / 10.0, " ms, and every ", std::round(1e4 * dt_) / 10.0, " ms before");
  if (last_) {
    if (row.x == last_->x && was_moving()) {
      mark_unusable(row.t, "the same row comes again and again, of an arm that moves");
      return;
    }
    const double step = row.t - last_->t;
    if (step > numbers_.pause) {
      mark_unusable(row.t, sparse.empty() ? "no usable row came" : sparse);
      restart();
    }
    speed_ = (row.x.head(n_) - last_->x.head(n_)) / step;
    mean_speed_ += std::min(1.0, step / numbers_.half_window) * (speed_ - mean_speed_);
    fastest_ = fastest_.cwiseMax(mean_speed_.cwiseAbs());
  }
  if (row.t - path_time_ < numbers_.pause) path_ += (row.t - path_time_) * row.x.segment(n_, n_);
  path_time_ = row.t;
  std::string why = signal_fault(row);
  if (why.empty() || why == contradiction_) why = sparse.empty() ? contradiction_ : sparse;
  if (why.empty()) {
    mark_usable(row.t);
    torque2_ += (row.x.tail(n_).cwiseAbs2() - torque2_) / static_cast<double>(++count_);
  } else {
    mark_unusable(row.t, why);
    if (contradiction_.empty() && (sparse.empty() || is_blind_)) return;
  }
  last_ = row;
  held_.wait(row);
  while (const std::optional<Row> known = held_.next()) resample(*known);
}

// Adds the grid's points between the previous row and this one.
void SmoothedRows::resample(const Row& row) {
  if (!resampled_) {
    first_t_ = row.t;
    next_ = 0;
    resampled_ = row;
  }
  for (double t; (t = first_t_ + static_cast<double>(next_) * dt_) <= row.t + kSameTime * dt_; ++next_)
    add_grid_point(t < row.t ? VectorXd(resampled_->x + (t - resampled_->t) / (row.t - resampled_->t) * (row.x - resampled_->x)) : row.x);
  resampled_ = row;
}

void SmoothedRows::add_grid_point(const VectorXd& x) {
  if (filled_ == window_.cols()) {
    std::copy(window_.data() + window_.rows(), window_.data() + window_.size(), window_.data());
    --filled_;
  }
  window_.col(filled_++) = x;
  window_.col(filled_ - 1).head(n_) -= offset_;
  if (filled_ < window_.cols()) return;
  const Motion motion = recent_motion();
  if (are_velocities_off(motion)) return;
  detect_jump(motion);
  if (filled_ == window_.cols()) smooth();
}

SmoothedRows::Motion SmoothedRows::recent_motion() const {
  const Eigen::Index count = 2 * reach_;
  const auto q = window_.block(0, filled_ - count - 1, n_, count + 1);
  const auto dq = window_.block(n_, filled_ - count - 1, n_, count + 1);
  Motion out;
  out.moved = q.col(count) - q.col(0);
  if (has_velocity_) {
    out.unexplained = out.moved - 0.5 * dt_ * (dq.leftCols(count) + dq.rightCols(count)).rowwise().sum();
    out.way = 0.5 * dt_ * (dq.leftCols(count).cwiseAbs() + dq.rightCols(count).cwiseAbs()).rowwise().sum();
    return out;
  }
  // Without velocities the increments on either side replace them.
  const VectorXd before = (q.col(reach_) - q.col(0)) / static_cast<double>(reach_);
  const VectorXd after = (q.col(count) - q.col(reach_ + 1)) / static_cast<double>(std::max(Eigen::Index{1}, reach_ - 1));
  out.unexplained = q.col(reach_ + 1) - q.col(reach_) - 0.5 * (before + after);
  out.way = 0.5 * static_cast<double>(count) * (before.cwiseAbs() + after.cwiseAbs());
  return out;
}

// True while the velocities are too large for their positions, or too small, also without any one of the joints: a clock
// that goes wrong, or another unit. It ends when they agree.
bool SmoothedRows::are_velocities_off(const Motion& motion) {
  if (!has_velocity_) return false;
  const double kept = 1.0 - std::min(1.0, dt_ / numbers_.clock_memory);
  const VectorXd ratio = (motion.moved - motion.unexplained).cwiseQuotient(motion.moved).cwiseMax(0.0).cwiseMin(2.0);
  const VectorXd weight = motion.moved.cwiseQuotient(fastest_.cwiseMax(kNothing)).cwiseAbs2();
  moved2_ = kept * moved2_ + weight;
  excess_ = kept * excess_ + (weight.array() == 0.0).select(0.0, (ratio.array() - 1.0).matrix().cwiseProduct(weight));
  if (!detects_jumps_) return false;
  const double rest = numbers_.clock_memory / dt_ * std::pow(numbers_.rest_share * 2.0 * static_cast<double>(reach_) * dt_, 2);
  const double moved = moved2_.sum(), excess = excess_.sum();
  if (moved < rest) return velocities_are_off_;
  bool off = true;
  for (Eigen::Index j = 0; j < n_; ++j) {
    const double others = moved - moved2_[j];
    off = off && others > rest && (excess - excess_[j]) * excess > 0.0 && std::abs(excess - excess_[j]) > numbers_.clock_error * others;
  }
  if (off) {
    if (!velocities_are_off_ && on_break) on_break();
    usable_ = std::min(usable_, time_of(filled_ - 1) - 2.0 * numbers_.clock_memory);
    contradiction_ = text(kContradiction, ": velocities are too ", excess > 0.0 ? "large" : "small", " on all joints, as by a clock that is too ", excess > 0.0 ? "fast" : "slow");
  }
  velocities_are_off_ = off || (velocities_are_off_ && std::abs(excess) > numbers_.clock_error * moved);
  return velocities_are_off_;
}

// Position increment over a few samples minus the integrated velocity. A late row deviates to one
// side and returns, so that only lasting jumps count.
void SmoothedRows::detect_jump(const Motion& motion) {
  seen_ += 1.0;
  std::vector<PositionJump> found;
  int jumping = 0;  // joints
  for (int j = 0; j < n_; ++j) {
    const double size = motion.unexplained[j];
    int& wait = wait_[j];
    if (wait > 0) {
      --wait;
      continue;
    }
    const bool slides = arm_.coordinates()[j].prismatic;
    const double least = std::max({numbers_.jump_over_largest * largest_[j],
                                   numbers_.jump_of_way * motion.way[j], slides ? numbers_.smallest_jump_sliding : numbers_.smallest_jump_turning});
    jumping += std::abs(size) > 0.5 * least ? 1 : 0;
    if (detects_jumps_ && sees_jumps_ && std::abs(size) > least) {
      found.push_back({jump_time(j), j, size, std::sqrt(spread2_[j])});
      continue;
    }
    spread2_[j] += (size * size - spread2_[j]) / seen_;
    largest_[j] = std::max(largest_[j], std::abs(size));
  }
  // Simultaneous jumps of several encoders indicate missing or joined rows, repeated ones a wrong velocity.
  bool contradicts = !found.empty() && jumping > 1;
  for (const PositionJump& jump : found) {
    double& last = last_jump_[jump.joint];
    contradicts = contradicts || jump.time - last < numbers_.pause;
    last = jump.time;
  }
  if (!contradicts) {
    for (const PositionJump& jump : found) subtract_jump(jump);
    return;
  }
  for (const PositionJump& jump : jumps_) offset_[jump.joint] -= jump.size;  // the position was right
  jumps_.clear();
  contradiction_ = kContradiction;
  if (on_break) on_break();
  window_.col(0) = window_.col(filled_ - 1);
  filled_ = 1;
}

// Time of the sample with the largest step of the position that its velocity does not explain.
double SmoothedRows::jump_time(int joint) const {
  if (!has_velocity_) return time_of(filled_ - reach_);
  Eigen::Index at = 0;
  const auto q = window_.row(joint).segment(filled_ - 2 * reach_ - 1, 2 * reach_ + 1);
  const auto dq = window_.row(n_ + joint).segment(filled_ - 2 * reach_ - 1, 2 * reach_ + 1);
  const Eigen::Index count = 2 * reach_;
  (q.tail(count) - q.head(count) - 0.5 * dt_ * (dq.tail(count) + dq.head(count))).cwiseAbs().maxCoeff(&at);
  return time_of(filled_ - count + at);
}

// From the first deviating sample on.
void SmoothedRows::subtract_jump(const PositionJump& jump) {
  jumps_.push_back(jump);
  for (Eigen::Index k = 0; k < filled_; ++k) {
    if (time_of(k) >= jump.time - 0.5 * dt_) window_(jump.joint, k) -= jump.size;
  }
  offset_[jump.joint] += jump.size;
  wait_[jump.joint] = static_cast<int>(2 * reach_);
}

void SmoothedRows::smooth() {
  contradiction_.clear();
  was_blind_ = false;
  report_jumps(time_of(filled_ - 1) - kAgain * numbers_.jump_reach);
  const MatrixXd smoothed = window_.topRows(2 * n_) * kernel_;
  SmoothedRow out;
  out.time = time_of(half_);
  out.q = smoothed.col(0).head(n_);
  out.dq = has_velocity_ ? smoothed.col(0).tail(n_) : smoothed.col(1).head(n_);
  out.ddq = has_velocity_ ? smoothed.col(1).tail(n_) : smoothed.col(2).head(n_);
  out.tau.resize(n_);
  for (int j = 0; j < n_; ++j) {  // delayed torques are shifted forward
    out.tau[j] = sensors_.torque_at({j}, half_, filled_, dt_, [&](Eigen::Index k) {
      return window_(2 * n_ + j, k);
    });
  }
  if (on_row) on_row(out);
}

// Those up to a time, since no other one of the same joint followed.
void SmoothedRows::report_jumps(double until) {
  while (!jumps_.empty() && jumps_.front().time <= until) {
    if (on_jump) on_jump(jumps_.front());
    jumps_.pop_front();
  }
}

void SmoothedRows::restart() {
  filled_ = 0;
  held_.drop_waiting();
  report_jumps(kInfinity);
  last_.reset();
  resampled_.reset();
  contradiction_.clear();
  if (on_break) on_break();
}

}  // namespace veridyn::watching
