#pragma once

#include <deque>
#include <functional>
#include <vector>

#include "veridyn/model/joint_sensors.hpp"
#include "veridyn/recordings/recording.hpp"
#include "watch/watch_numbers.hpp"

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

/// Prepares rows of a running arm for the equations of motion: skips gaps and repeated rows,
/// interpolates on a uniform grid, corrects channels as the MODEL says, detects and removes jumps
/// of an encoder, and estimates velocity and acceleration by local least squares.
class SmoothedRows {
 public:
  SmoothedRows(const Model& arm, const WatchNumbers& numbers);

  /// Called with each finished row and each jump, in the order of time.
  std::function<void(const SmoothedRow&)> on_row;
  std::function<void(const PositionJump&)> on_jump;
  std::function<void()> on_break;  ///< after a pause; the next row is not contiguous

  /// @throws InvalidInput  another number of joints, neither torques nor currents with drive gains.
  void check(const Recording& rows) const;
  void add(const Recording& rows);
  double dt() const { return dt_; }

  /// Enables the detection of jumps, once the noise of positions is known.
  void tell_jumps() { tell_jumps_ = true; }

 private:
  struct Row {
    double t;
    VectorXd q, dq, tau;
  };
  bool take(const Recording& rows, int k, Row& row) const;
  void place(const Row& row);
  void put(Row row);
  struct Gain {
    double size = 0.0;  ///< minus the integrated velocity [rad] or [m]
    double way = 0.0;   ///< displacement of the joint
    double at = 0.0;    ///< [s] of the largest step
  };
  void look_for_jump();
  Gain gained(int joint, int begin, int end) const;
  void take_off(const PositionJump& jump, int end);
  void smooth();
  void begin_again();

  const WatchNumbers& numbers_;
  Model arm_;
  JointSensors sensors_;
  bool has_velocity_ = false, tell_jumps_ = false;
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
  VectorXd largest_;                // and its largest while quiet
  double seen_ = 0.0;
  std::vector<int> wait_;           // samples until the next jump of a joint may be reported
};

}  // namespace veridyn::watching
