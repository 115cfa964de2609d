#pragma once

#include <cmath>
#include <deque>
#include <functional>
#include <string>
#include <vector>

#include "veridyn/model/joint_sensors.hpp"
#include "veridyn/recordings/recording.hpp"
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

/// Prepares rows of a running arm for the equations of motion: skips gaps and repeated rows,
/// interpolates on a uniform grid, corrects channels by the model, detects and removes jumps
/// of an encoder, and estimates velocity and acceleration by local least squares.
///
/// Rows whose times do not rise above the last one's are skipped. Where they rise among themselves for half a
/// pause the clock was set back: on_blind reports it, and smoothing restarts.
class SmoothedRows {
 public:
  SmoothedRows(const Model& arm, const WatchNumbers& numbers);

  /// Called with each finished row and each jump, in the order of time.
  std::function<void(const SmoothedRow&)> on_row;
  std::function<void(const PositionJump&)> on_jump;
  std::function<void(const Blindness&)> on_blind;
  std::function<void()> on_break;  ///< after a pause; the next row is not contiguous

  /// @throws InvalidInput  another number of joints, neither torques nor currents with drive gains, no
  /// velocities after rows with them.
  void check(const Recording& rows) const;
  void add(const Recording& rows);
  double dt() const { return dt_; }
  double last_row_time() const { return heard_; }  ///< [s] of the last row, usable or not
  double blind() const { return blind_ + (is_blind_ ? heard_ - usable_ : 0.0); }

  /// Enables the detection of jumps, once the noise of positions is known.
  void enable_jump_detection() { detects_jumps_ = true; }

  /// Reports what waits for more rows, at the end.
  void finish() { report_jumps(heard_); }

 private:
  struct Row {
    double t;
    VectorXd q, dq, tau;
  };
  void copy_row(const Recording& rows, int k, Row& row) const;
  std::string fault(const Row& row) const;
  /// A signal of every joint that may stay the same while its joint moves.
  struct Standing {
    VectorXd value, since, from, longest;  ///< (n) present value, since when [s], path then, longest such time before [s]
    std::vector<char> never_changed, stopped;
  };
  std::string stuck_reason(Standing& standing, const char* signal, const VectorXd& value, const VectorXd& path, double time);
  bool moved() const;
  bool is_clock_continuous(double time);
  void restart_clock(double time, double before);
  void mark_unusable(double time, const std::string& why);
  void mark_usable(double time);
  void place(const Row& row);
  void put(Row row);
  struct Gain {
    double size = 0.0;  ///< minus the integrated velocity [rad] or [m]
    double way = 0.0;   ///< displacement of the joint
    double at = 0.0;    ///< [s] of the largest step
  };
  void detect_jump();
  Gain integrated_motion(int joint, int begin, int end) const;
  void subtract_jump(const PositionJump& jump, int end);
  void report_jumps(double until);
  void smooth();
  void restart();

  const WatchNumbers& numbers_;
  Model arm_;
  JointSensors sensors_;
  bool has_velocity_ = false, detects_jumps_ = false;
  double dt_ = 0.0;
  std::deque<Row> start_;  // until the time step is known
  Row last_;
  bool has_last_ = false;
  int repeats_ = 0;
  long next_ = 0;
  double first_t_ = 0.0;
  std::deque<Row> grid_;
  int half_ = 0;  // of the smoothing window
  int reach_ = 0; // half width of the window for jumps
  VectorXd value_, slope_, curve_;  // kernels over 2 half + 1 samples
  VectorXd offset_;                 // jumps found so far
  VectorXd spread2_;                // mean square of the jump statistic
  VectorXd torque2_;                // (n) mean square of the torques of usable rows
  long count_ = 0;                  // of these rows
  VectorXd largest_;                // and its largest while quiet
  double seen_ = 0.0;
  // Last usable row and last row of all [s].
  double usable_ = 0.0, heard_ = 0.0, blind_ = 0.0;
  bool heard_any_ = false, is_blind_ = false;
  double placed_ = HUGE_VAL;  // [s] time of the last row that came to place()
  long back_ = 0;  // rows in a row whose time does not rise above the last one's
  double back_first_ = 0.0, back_last_ = 0.0;  // [s] between which their times rise
  Standing torque_, position_;
  VectorXd path_;  // (n) integrated velocity [rad], [m] until path_time_ [s]
  double path_time_ = 0.0;
  bool contradicts_ = false;  // positions have jumped on several joints or repeatedly, and no row was smoothed since
  bool was_blind_ = false;    // and this was reported, and no row was smoothed since
  std::deque<PositionJump> jumps_;  // not yet reported
  VectorXd last_jump_;              // (n) [s]
  VectorXd speed_, mean_speed_, fastest_;  // (n) of the last row, smoothed, and the largest of that
  std::vector<int> wait_;           // samples until the next jump of a joint may be reported
};

}  // namespace veridyn::watching
