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
    : numbers_(numbers),
      arm_(arm),
      sensors_(arm),
      offset_(VectorXd::Zero(arm.joints())),
      spread2_(VectorXd::Zero(arm.joints())),
      torque2_(VectorXd::Zero(arm.joints())),
      largest_(VectorXd::Zero(arm.joints())),
      last_jump_(VectorXd::Constant(arm.joints(), -kInfinity)),
      speed_(VectorXd::Zero(arm.joints())),
      mean_speed_(VectorXd::Zero(arm.joints())),
      fastest_(VectorXd::Zero(arm.joints())),
      wait_(static_cast<size_t>(arm.joints()), 0) {}

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
std::string SmoothedRows::fault(const Row& row) const {
  const auto joint = [this](const char* signal, Eigen::Index j) {
    return text(signal, j + 1, " (", arm_.coordinates()[j].name, ")");
  };
  for (Eigen::Index j = 0; j < row.q.size(); ++j) {
    for (const auto& [name, value] : {std::pair{"q", row.q[j]}, {"dq", row.dq[j]}, {"tau", row.tau[j]}}) {
      if (!std::isfinite(value)) return joint(name, j) + " is no number";
      if (std::abs(value) >= kAbsurd) return joint(name, j) + " is " + text(value);
    }
  }
  if (!arm_.gravity().isZero(0.0) && (row.tau.cwiseAbs2().array() <= numbers_.no_torque * numbers_.no_torque * torque2_.array()).all())
    return "the torques of all joints are zero: no drive is on, or none is recorded";
  return "";
}

// A signal that stays the same to the last digit while its joint moves, longer than ever before: its sensor or drive
// does not answer, or it is saturated.
// @param path  (n) a measure of the joints' motion, which the signal does not enter.
std::string SmoothedRows::stuck_reason(Standing& s, const char* signal, const VectorXd& value, const VectorXd& path, double time) {
  const Eigen::Index n = value.size();
  if (s.value.size() == 0) s = {value, VectorXd::Constant(n, time), path, VectorXd::Zero(n), std::vector<char>(static_cast<size_t>(n), 1), std::vector<char>(static_cast<size_t>(n), 0)};
  std::string why;
  for (Eigen::Index j = 0; j < n; ++j) {
    char& never = s.never_changed[static_cast<size_t>(j)];
    char& stopped = s.stopped[static_cast<size_t>(j)];
    if (value[j] != s.value[j]) {
      if (never == 0 && !is_blind_) s.longest[j] = std::max(s.longest[j], usable_ - s.since[j]);
      never = stopped = 0;
      s.value[j] = value[j];
      s.from[j] = path[j];
      s.since[j] = time;
      continue;
    }
    const double least = numbers_.rest_share * fastest_[j] * (time - s.since[j]);
    const bool moves = std::abs(path[j] - s.from[j]) > least;
    const bool longer = time - s.since[j] > std::max(numbers_.pause, 2.0 * s.longest[j]);
    if (stopped == 0 && (never != 0 || !moves || !longer)) continue;
    stopped = 1;
    usable_ = std::min(usable_, s.since[j]);
    why = text(signal, j + 1, " (", arm_.coordinates()[j].name, ") stays at ", s.value[j], " while the joint moves");
  }
  return why;
}

// True if the arm moved when the last row came: one that repeats it is no rest.
bool SmoothedRows::moved() const {
  return (speed_.cwiseAbs().cwiseMin(mean_speed_.cwiseAbs()).array() > numbers_.rest_share * fastest_.array()).any();
}

void SmoothedRows::mark_unusable(double time, const std::string& why) {
  heard_ = time;
  if (!heard_any_) usable_ = time;  // unusable from the first row on
  heard_any_ = true;
  if (is_blind_ || time - usable_ <= numbers_.pause) return;
  is_blind_ = true;
  if (on_blind && !was_blind_) on_blind({usable_, time, why});
  was_blind_ = true;
}

// False for a row whose time does not rise, until the clock is known to have been set back, as by the start
// of another controller.
bool SmoothedRows::is_clock_continuous(double time) {
  if (!has_last_ || time > last_.t) {
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
  const double by = last_.t + dt_ - back_first_;
  blind_ += before - usable_;
  is_blind_ = false;
  if (on_blind) on_blind({usable_, before, text("the clock was set back to ", back_first_, " s, and the watch begins anew"), by});
  for (Standing* s : {&torque_, &position_}) s->since.array() -= by;
  path_time_ -= by;
  back_ = 0;
  usable_ = heard_ = time;
  restart();
}

void SmoothedRows::mark_usable(double time) {
  if (is_blind_) {
    blind_ += time - usable_;
    is_blind_ = false;
  }
  usable_ = heard_ = time;
  heard_any_ = true;
}

void SmoothedRows::copy_row(const Recording& rows, int k, Row& row) const {
  const int n = arm_.joints();
  row.t = rows.time[k];
  row.q = rows.q.row(k).transpose();
  row.dq = has_velocity_ ? VectorXd(rows.dq.row(k).transpose()) : VectorXd::Zero(n);
  const bool torques = rows.tau.size() > 0;
  row.tau = torques ? rows.tau.row(k).transpose() : rows.current.row(k).transpose();
  sensors_.correct_positions(row.q);
  if (torques) {
    sensors_.correct_torques(row.tau);
  } else {
    sensors_.correct_currents(row.tau);
  }
}

void SmoothedRows::add(const Recording& rows) {
  if (rows.rows() == 0) return;
  check(rows);
  if (dt_ == 0.0 && start_.empty()) has_velocity_ = rows.dq.size() > 0;
  Row row;
  for (int k = 0; k < rows.rows(); ++k) {
    copy_row(rows, k, row);
    if (!std::isfinite(row.t) || !is_clock_continuous(row.t)) continue;
    if (const std::string why = fault(row); !why.empty()) {
      mark_unusable(row.t, why);
      continue;
    }
    if (dt_ > 0.0) {
      place(row);
      continue;
    }
    start_.push_back(row);
    if (start_.size() < static_cast<size_t>(numbers_.rows_for_step)) continue;
    std::vector<double> times;
    for (const Row& one : start_) times.push_back(one.t);
    dt_ = median_step(times);
    require(dt_ > 0.0, rows.source, ": found times that do not rise, expected a clock.");
    half_ = std::max(3, static_cast<int>(std::lround(
                            (has_velocity_ ? numbers_.half_window : numbers_.half_window_of_position) / dt_)));
    reach_ = std::clamp(static_cast<int>(std::lround(numbers_.jump_reach / dt_)), 2, half_ - 1);
    const MatrixXd kernel = local_polynomial(half_, has_velocity_ ? 2 : 3);
    value_ = kernel.row(0);
    slope_ = kernel.row(1) / dt_;
    curve_ = kernel.row(2) / (dt_ * dt_);
    for (const Row& one : start_) {
      if (is_clock_continuous(one.t)) place(one);
    }
    start_.clear();
  }
}

// Processes one recorded row: the grid points between it and the previous row.
void SmoothedRows::place(const Row& row) {
  // The window of the smoothing holds so few rows that the lines between them have other derivatives.
  const double apart = row.t - std::exchange(placed_, row.t);
  std::string sparse;
  if (2.0 * apart > half_ * dt_ && apart <= numbers_.pause)
    sparse = text("rows come every ", std::round(1e4 * apart) / 10.0, " ms, and every ", std::round(1e4 * dt_) / 10.0, " ms before");
  if (has_last_) {
    const bool same = row.q == last_.q && row.tau == last_.tau;
    if (same && moved()) {
      mark_unusable(row.t, "the same row comes again and again, of an arm that moves");
      return;
    }
    if (row.t - last_.t > numbers_.pause) {
      mark_unusable(row.t, sparse.empty() ? "no usable row came" : sparse);
      restart();
    } else if (same && repeats_ < numbers_.repeats) {
      ++repeats_;  // repeated row: interpolated once a new row arrives
      return;
    }
    speed_ = (row.q - last_.q) / (row.t - last_.t);
    mean_speed_ += std::min(1.0, (row.t - last_.t) / numbers_.half_window) * (speed_ - mean_speed_);
    fastest_ = fastest_.cwiseMax(mean_speed_.cwiseAbs());
  }
  repeats_ = 0;
  if (path_.size() == 0) path_ = VectorXd::Zero(row.q.size());
  if (row.t - path_time_ < numbers_.pause) path_ += (row.t - path_time_) * row.dq;
  path_time_ = row.t;
  std::string why = stuck_reason(torque_, "tau", row.tau, row.q, row.t);
  if (why.empty() && has_velocity_) why = stuck_reason(position_, "q", row.q, path_, row.t);
  if (why.empty()) why = sparse;
  if (why.empty() && contradicts_) why = "positions and velocities contradict each other";
  if (why.empty()) {
    mark_usable(row.t);
    torque2_ += (row.tau.cwiseAbs2() - torque2_) / static_cast<double>(++count_);
  } else {
    mark_unusable(row.t, why);
    if (!contradicts_ && (sparse.empty() || is_blind_)) return;
  }
  if (!has_last_) {
    first_t_ = row.t;
    next_ = 0;
    last_ = row;
    has_last_ = true;
  }
  for (double t; (t = first_t_ + static_cast<double>(next_) * dt_) <= row.t + kSameTime * dt_; ++next_) {
    Row between = row;
    if (t < row.t) {
      const double share = (t - last_.t) / (row.t - last_.t);
      between.q = last_.q + share * (row.q - last_.q);
      between.dq = last_.dq + share * (row.dq - last_.dq);
      between.tau = last_.tau + share * (row.tau - last_.tau);
    }
    between.t = t;
    put(std::move(between));
  }
  last_ = row;
}

void SmoothedRows::put(Row row) {
  row.q -= offset_;
  grid_.push_back(std::move(row));
  if (static_cast<int>(grid_.size()) > 2 * half_ + 1) grid_.pop_front();
  if (static_cast<int>(grid_.size()) < 2 * half_ + 1) return;
  detect_jump();
  if (static_cast<int>(grid_.size()) == 2 * half_ + 1) smooth();
}

// Position increment over a few samples minus the integrated velocity. A late row deviates to one
// side and returns, so that only lasting jumps count.
void SmoothedRows::detect_jump() {
  const int end = static_cast<int>(grid_.size()) - 1;
  const int begin = end - 2 * reach_;  // within the window, for reach_ < half_
  seen_ += 1.0;
  std::vector<PositionJump> found;
  int jumping = 0;  // joints
  for (int j = 0; j < arm_.joints(); ++j) {
    const Gain gain = integrated_motion(j, begin, end);
    int& wait = wait_[j];
    if (wait > 0) {
      --wait;
      continue;
    }
    const double spread = std::sqrt(spread2_[j]);
    const bool slides = arm_.coordinates()[j].prismatic;
    const double least = std::max({numbers_.jump_deviations * spread, numbers_.jump_over_largest * largest_[j],
                                   numbers_.jump_of_way * gain.way, slides ? numbers_.smallest_jump_sliding : numbers_.smallest_jump_turning});
    jumping += std::abs(gain.size) > 0.5 * least ? 1 : 0;
    if (detects_jumps_ && std::abs(gain.size) > least) {
      found.push_back({gain.at, j, gain.size, spread});
      continue;
    }
    spread2_[j] += (gain.size * gain.size - spread2_[j]) / seen_;
    largest_[j] = std::max(largest_[j], std::abs(gain.size));
  }
  // Simultaneous jumps of several encoders indicate missing or joined rows, repeated ones a wrong velocity.
  bool contradicts = !found.empty() && jumping > 1;
  for (const PositionJump& jump : found) {
    double& last = last_jump_[jump.joint];
    contradicts = contradicts || jump.time - last < numbers_.pause;
    last = jump.time;
  }
  if (contradicts) {
    const Row last = grid_.back();
    for (const PositionJump& jump : jumps_) offset_[jump.joint] -= jump.size;  // the position was right
    jumps_.clear();
    restart();
    contradicts_ = true;
    first_t_ = last.t;
    next_ = 1;
    grid_.push_back(last);
    has_last_ = true;
    return;
  }
  for (const PositionJump& jump : found) subtract_jump(jump, end);
}

SmoothedRows::Gain SmoothedRows::integrated_motion(int j, int begin, int end) const {
  Gain out;
  const auto row = [this](int k) -> const Row& { return grid_[k]; };
  const auto step = [&](int k) {  // from sample k - 1 to k, minus the integrated velocity
    return row(k).q[j] - row(k - 1).q[j] - 0.5 * dt_ * (row(k - 1).dq[j] + row(k).dq[j]);
  };
  // Without velocities the increments on either side replace them.
  const int mid = (begin + end) / 2;
  const double before = (row(mid).q[j] - row(begin).q[j]) / (mid - begin);
  const double after = (row(end).q[j] - row(mid + 1).q[j]) / std::max(1, end - mid - 1);
  double largest = 0.0;
  for (int k = begin + 1; k <= end; ++k) {
    if (has_velocity_) {
      out.size += step(k);
      out.way += 0.5 * dt_ * (std::abs(row(k - 1).dq[j]) + std::abs(row(k).dq[j]));
    }
    if (std::abs(step(k)) <= largest) continue;
    largest = std::abs(step(k));
    out.at = row(k).t;
  }
  if (!has_velocity_) {
    out.size = row(mid + 1).q[j] - row(mid).q[j] - 0.5 * (before + after);
    out.way = 0.5 * (std::abs(before) + std::abs(after)) * (end - begin);
    out.at = row(mid + 1).t;
  }
  return out;
}

// The jump is located at the first deviating sample.
void SmoothedRows::subtract_jump(const PositionJump& jump, int end) {
  jumps_.push_back(jump);
  for (int k = 0; k <= end; ++k) {
    Row& row = grid_[k];
    if (row.t >= jump.time - 0.5 * dt_) row.q[jump.joint] -= jump.size;
  }
  offset_[jump.joint] += jump.size;
  wait_[jump.joint] = 2 * reach_;
}

void SmoothedRows::smooth() {
  contradicts_ = was_blind_ = false;
  report_jumps(grid_.back().t - kAgain * numbers_.jump_reach);
  const int n = arm_.joints();
  const int count = 2 * half_ + 1;
  SmoothedRow out;
  out.time = grid_[half_].t;
  out.q = VectorXd::Zero(n);
  out.dq = VectorXd::Zero(n);
  out.ddq = VectorXd::Zero(n);
  out.tau = grid_[half_].tau;
  for (int i = 0; i < count; ++i) {
    const Row& row = grid_[i];
    out.q += value_[i] * row.q;
    out.dq += has_velocity_ ? VectorXd(value_[i] * row.dq) : VectorXd(slope_[i] * row.q);
    out.ddq += has_velocity_ ? VectorXd(slope_[i] * row.dq) : VectorXd(curve_[i] * row.q);
  }
  for (int j = 0; j < n; ++j) {  // delayed torques are shifted forward
    out.tau[j] = sensors_.torque_at(j, half_, count, dt_, [&](Eigen::Index k) {
      return grid_[k].tau[j];
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
  grid_.clear();
  report_jumps(kInfinity);
  has_last_ = contradicts_ = false;
  repeats_ = 0;
  if (on_break) on_break();
}

}  // namespace veridyn::watching
