#pragma once

#include <cmath>
#include <deque>
#include <functional>
#include <string>
#include <vector>

#include "veridyn/model/joint_sensors.hpp"
#include "veridyn/recordings/recording.hpp"
#include "diagnosis/watch/held_signals.hpp"
#include "diagnosis/watch/watch_numbers.hpp"

namespace veridyn::watching {

/// A sample of a uniform grid, smoothed by local polynomials; it lags by `half` samples.
struct SmoothedRow {
  double time = 0.0;
  VectorXd q, dq, ddq, tau;
};

/// A lasting jump of a recorded position without a corresponding motion.
struct PositionJump {
  double time = 0.0;
  int joint = 0;
  double size = 0.0;   ///< recorded minus true [rad] or [m]
  double noise = 0.0;  ///< standard deviation of `size`
};

/// A time without usable rows, longer than a pause.
struct Blindness {
  double since = 0.0;  ///< [s] last usable row
  double time = 0.0;   ///< [s] at which it was noticed
  std::string why;
  /// [s] by which the clock was set back; the rows that follow count as usable, by the new clock. 0: it was not.
  double set_back = 0.0;
};

/// A wrong clock: it counts `factor` seconds in one true second.
struct RowClock {
  double origin = 0.0;  ///< [s] at which both agree
  double factor = 1.0;

  double true_time(double t) const { return origin + (t - origin) / factor; }
  double recorded_time(double t) const { return origin + (t - origin) * factor; }
};

/// Prepares rows of a running arm for the equations of motion: skips gaps and repeated rows, interpolates
/// signals between their new values and on a uniform grid, corrects channels by the model, detects and removes
/// jumps of an encoder, and estimates velocity and acceleration by local least squares.
///
/// Rows whose times do not rise above the last one's are skipped. Where they rise among themselves for half a
/// pause the clock was set back: on_blind reports it, and smoothing restarts. Where velocities of all moving
/// joints are another multiple of the derivative of their positions, the clock or all velocities are wrong, and
/// no row is usable.
class SmoothedRows {
 public:
  SmoothedRows(const Model& arm, const WatchNumbers& numbers);

  /// Called with each finished row and each jump, in the order of time.
  std::function<void(const SmoothedRow&)> on_row;
  std::function<void(const PositionJump&)> on_jump;
  std::function<void(const Blindness&)> on_blind;
  std::function<void()> on_break;  ///< called after a pause: the next row is not contiguous

  /// @throws InvalidInput  another number of joints, neither torques nor currents with drive gains, no
  /// velocities after rows with them.
  void check(const Recording& rows) const;
  void add(const Recording& rows);  ///< all rows of a recording, in order of time
  double dt() const { return dt_; }  ///< [s] of the grid; 0 until it is known
  double spacing() const { return spacing_; }  ///< [s] between new values of the slowest signal
  double last_row_time() const { return last_row_time_; }  ///< [s] of the last row, usable or not
  double blind() const { return blind_ + (is_blind_ ? last_row_time_ - usable_ : 0.0); }  ///< [s] total time without usable rows

  /// The times of further rows are those of this clock; all reports have true times.
  void set_clock(const RowClock& clock) { clock_ = clock; }

  /// Enables the detection of jumps, once the noise of positions is known.
  void enable_jump_detection() { detects_jumps_ = true; }

  /// Reports the remaining jumps, after the last row.
  void finish() { report_jumps(last_row_time_); }

 private:
  void copy_row(const Recording& rows, int k, Row& row) const;
  std::string row_fault(const Row& row) const;
  bool was_moving() const;
  bool is_clock_continuous(double time);
  void restart_clock(double time, double before);
  void mark_unusable(double time, const std::string& why);
  void mark_usable(double time);
  void choose_windows();  ///< chooses time step and windows
  void accept(const Row& row);  ///< checks a row and passes it on
  void queue(const Row& row);  ///< compares a usable row with its predecessors and queues it
  std::string signal_fault(const Row& row);
  void resample(const Row& row);
  void add_grid_point(const VectorXd& x);  ///< adds a point of the grid to the window
  /// (n) motion over the last samples [rad], [m].
  struct Motion {
    VectorXd moved;       ///< difference of the positions
    VectorXd unexplained; ///< that difference minus the integrated velocity
    VectorXd way;         ///< integrated speed
  };
  Motion recent_motion() const;
  bool are_velocities_off(const Motion& motion);
  void detect_jump(const Motion& motion);
  double jump_time(int joint) const;
  void subtract_jump(const PositionJump& jump);
  void report_jumps(double until);
  void smooth();
  void restart();
  /// [s] of a sample of the window.
  double time_of(Eigen::Index sample) const { return first_t_ + static_cast<double>(next_ + 1 + sample - filled_) * dt_; }

  const WatchNumbers& numbers_;
  Model arm_;
  Eigen::Index n_;
  JointSensors sensors_;
  RowClock clock_;
  bool has_velocity_ = false, detects_jumps_ = false, sees_jumps_ = true;
  double dt_ = 0.0, spacing_ = 0.0;
  std::deque<Row> start_;  // first rows, until the time step is known
  HeldSignals held_;
  std::optional<Row> last_, resampled_;  // last row that was received, and last row that was resampled
  long next_ = 0;                        // index of the next point of the grid
  double first_t_ = 0.0;
  MatrixXd window_;           // (3 n x 2 half + 1) samples of the grid
  Eigen::Index filled_ = 0;   // number of samples in the window
  Eigen::Index half_ = 0;     // half width of the smoothing window
  Eigen::Index reach_ = 0;    // half width of the window for jumps
  MatrixXd kernel_;           // (2 half + 1 x 3) value, slope, curve at its middle
  VectorXd offset_;           // jumps found so far
  VectorXd spread2_;          // mean square of the jump statistic
  VectorXd largest_;          // largest jump statistic without a jump
  VectorXd moved2_, excess_;  // (n) forgetting sums of squared motion, and of the share of it by which its velocity is too large
  VectorXd torque2_;          // (n) mean square of the torques of usable rows
  long count_ = 0;            // number of usable rows
  double seen_ = 0.0;
  // [s] time of the last usable row, of the last row, and total time without usable rows
  double usable_ = 0.0, last_row_time_ = 0.0, blind_ = 0.0;
  bool has_row_ = false, is_blind_ = false;
  double placed_ = HUGE_VAL;  // [s] time of the last row that came to queue()
  long back_ = 0;  // rows in a row whose time does not rise above the last one's
  double back_first_ = 0.0, back_last_ = 0.0;  // [s] between which their times rise
  VectorXd path_;  // (n) integrated velocity [rad], [m] until path_time_ [s]
  double path_time_ = 0.0;
  bool velocities_are_off_ = false;
  std::string contradiction_;  // positions and velocities contradict each other, and no row was smoothed since
  bool was_blind_ = false;     // and this was reported, and no row was smoothed since
  std::deque<PositionJump> jumps_;  // not yet reported
  VectorXd last_jump_;              // (n) [s]
  VectorXd speed_, mean_speed_, fastest_;  // (n) of the last row, smoothed, and the largest of that
  std::vector<int> wait_;           // samples until the next jump of a joint may be reported
};

}  // namespace veridyn::watching
