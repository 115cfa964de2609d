#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "recordings/quality/quality_numbers.hpp"
#include "veridyn/recordings/recording_quality.hpp"

/// The parts of check_recording(). A *tally* processes every row, piece by piece; a *check* sees
/// the first rows only.
namespace veridyn::quality {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Signal, joint and size of a finding; all else is in its sentence.
struct Place {
  std::string signal;
  int joint = 0;
};

struct Size {
  double share = kNone;
  double value = kNone;
  std::string unit;
};

/// Collects findings of one file.
class Findings {
 public:
  explicit Findings(std::string file) : file_(std::move(file)) {}
  void add(Severity severity, const std::string& finding, const Place& place, const Size& size,
           const std::string& sentence);
  std::vector<QualityFinding> sorted() &&;

 private:
  std::string file_;
  std::vector<QualityFinding> findings_;
};

/// A piece of the recording; rows before `fresh` have been processed.
struct Piece {
  const Recording& rows;
  int fresh;
};

/// The first rows, without absurd numbers, and scales computed from them.
struct Head {
  explicit Head(const Recording& recording);

  const Recording& rows;
  double step = 0.0;        // [s] median
  double shortest = 0.0;    // [s] 1 % quantile of the steps
  double longest = 0.0;     // [s] 99 % quantile of the steps
  std::vector<bool> moves;  // per joint
  std::vector<bool> stale;  // per row: equal to the row before while the arm moves
};

/// Number of rows in QualityNumbers::window.
int window_rows(const Head& head);

/// Text such as "joint 3 (tau)".
std::string named(const Place& place);
/// A number as text: four significant digits; shares as "12 %"; counts as "1 row", "2 rows".
std::string number(double value);
std::string percent(double share);
std::string counted(long count, const std::string& noun);
/// Unit of a signal of a joint of unknown type, for example "N m".
std::string unit_of(const std::string& signal);

/// Value at the given share (0 to 1) of the sorted finite values; NaN if there are none.
double quantile(std::vector<double> values, double share);

/// True if quantile(values, share) > bound; it does not sort the values.
bool quantile_exceeds(const std::vector<double>& values, double share, double bound);

/// The difference of two quantiles, of which the upper one is `high`.
double between_quantiles(std::vector<double> values, double low, double high);

std::vector<double> column_of(const MatrixXd& values, Eigen::Index joint);
/// Range of a column without single wrong values: between its quantiles `ends` and 1 - `ends`.
double range_of(const MatrixXd& values, Eigen::Index joint);
/// Sizes of a column's changes from row to row, zeros excluded; and its smallest usual change, 0 if nothing
/// changes.
std::vector<double> changes_of(const MatrixXd& values, Eigen::Index joint);
double resolution_of(const MatrixXd& values, Eigen::Index joint);

/// True if row k equals row k - 1 in every signal although the arm moves.
bool is_stale(const Recording& rows, int k);
/// True if a velocity of row k is not zero; without velocities, if a position has changed within 6 rows.
bool is_moving(const Recording& rows, int k);

/// Replaces numbers beyond +-1e6 in rows from `fresh` on by NaN, and counts them.
class AbsurdTally {
 public:
  void clean(Recording* rows, int fresh);
  double share() const {
    return rows_ == 0 ? 0.0 : static_cast<double>(bad_rows_) / static_cast<double>(rows_);
  }
  void conclude(Findings* findings) const;

 private:
  long rows_ = 0;
  long bad_rows_ = 0;
  long bad_values_ = 0;
  double first_time_ = 0.0;
};

class TimeTally {
 public:
  explicit TimeTally(const Head& head)
      : step_(head.step), shortest_(head.shortest), longest_(head.longest) {}
  void add(const Piece& piece);
  void conclude(Findings* findings) const;

 private:
  double step_;
  double shortest_;
  double longest_;
  long rows_ = 0;
  double first_ = 0.0;
  double last_ = 0.0;
  long holes_ = 0;
  double lost_rows_ = 0.0;
  double lost_time_ = 0.0;
  double longest_hole_ = 0.0;
  double longest_hole_at_ = 0.0;
  long alike_ = 0;               // holes directly after another one of the same length
  double hole_before_ = kNone;   // [rows] length of the hole before, or none
  double first_hole_at_ = kNone, length_ = 0.0;  // position of the first hole; length of the equal ones
};

/// Counts stale rows, gaps, and constant signals.
class RowTally {
 public:
  explicit RowTally(const Head& head);
  void add(const Piece& piece);
  void conclude(Findings* findings) const;

 private:
  struct Channel {
    Place place;
    double first = kNone;
    bool constant = true;
    double largest = 0.0;
    long gaps = 0;
    long gap_run = 0;
    long longest_gap = 0;
  };
  void conclude_gaps(Findings* findings) const;
  void add_gaps(const Channel& channel, const Place& place, const std::string& who,
                Findings* findings) const;
  void conclude_constant(Findings* findings) const;

  std::vector<Channel> channels_;
  long rows_ = 0;
  long stale_ = 0;
  long stale_run_ = 0;
  long longest_stale_ = 0;
  std::vector<long> beyond_;  // per joint: rows with |q| > 2 turns
};

class JumpTally {
 public:
  explicit JumpTally(const Head& head);
  void add(const Piece& piece);
  void conclude(Findings* findings) const;

 private:
  bool is_jump(const Recording& rows, int k, int joint) const;

  struct Joint {
    double tolerance = 0.0;
    long count = 0, onward = 0;  ///< jumps; those in the direction of the step before
    double largest = 0.0;
    double largest_at = 0.0;
  };
  double step_;
  std::vector<Joint> joints_;
};

/// Detects torque or current at its extreme value in successive rows: entered and left abruptly, or at two
/// limits of equal size.
class ClipTally {
 public:
  explicit ClipTally(const Head& head);
  void add(const Piece& piece);
  /// @param saturated  set to the intervals of torques at a nonzero limit.
  void conclude(Findings* findings, std::vector<SaturatedInterval>* saturated) const;

 private:
  struct Extreme {
    Place place;
    double sign = 1.0;  // +1: largest, -1: smallest value
    double tolerance = 0.0;
    double limit = -std::numeric_limits<double>::infinity();  // sign * value
    long run = 0;
    double entry = 0.0;  // size of the step into the run
    bool abrupt = false;  // a run of at least three rows was entered and left abruptly
    long rows = 0;        // number of rows at the limit
    long longest = 0;
    long below = 0;  // rows at the next smaller value of the channel
    std::vector<SaturatedInterval> stretches = {};
  };
  void add_value(double value, double before, double time, Extreme* extreme) const;
  bool is_limit(const Extreme& one, const Extreme& opposite) const;
  void close_run(double after, Extreme* extreme) const;

  std::vector<Extreme> extremes_;  // largest and smallest value alternate
  double start_ = 0.0;             // [s]
  long rows_ = 0;
};

/// Recorded torques and currents.
struct Load {
  const char* name;
  const MatrixXd* values;
};
std::vector<Load> loads_of(const Recording& rows);
/// "torque" or "current".
const char* word_of_load(const std::string& signal);

double share_of(long count, long rows);

void check_motion(const Head& head, Findings* findings);
void check_velocities(const Head& head, Findings* findings);
/// Delay of dq behind the derivative of q [s], if significant.
std::optional<double> velocity_delay(const Head& head, int joint);
void check_stale_signals(const Head& head, Findings* findings);
void check_saturated_plateaus(const Head& head, Findings* findings);
/// Torques and currents whose changes are all larger than a share of their range.
void check_torque_steps(const Head& head, Findings* findings);
void check_start_up(const Head& head, Findings* findings);
void check_period(const MotionPeriod& period, Findings* findings);

}  // namespace veridyn::quality
