#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "recordings/quality/quality_numbers.hpp"
#include "veridyn/recordings/recording_quality.hpp"

/// The parts of check_recording(). A *tally* processes every row, piece by piece; a *check* sees
/// the first rows only. Both look at *channels*, the columns of a recording.
namespace veridyn::quality {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Signal, joint and size of a finding; all else is in its sentence.
struct Place {
  std::string signal;
  std::optional<JointIndex> joint = {};
};

struct Size {
  double share = kNone;
  double value = kNone;
  std::string unit;
};

/// Adds findings to the quality of a file.
class Findings {
 public:
  explicit Findings(RecordingQuality* quality) : quality_(quality) {}
  void add(Severity severity, QualityKind kind, const Place& place, const Size& size, const std::string& sentence);
  void add_saturated(const std::vector<SaturatedInterval>& intervals);

 private:
  RecordingQuality* quality_;
};

inline bool is_load(const RecordingSignal& signal) {
  return signal.values == &Recording::tau || signal.values == &Recording::current;
}

/// One signal of one joint.
struct Channel {
  const RecordingSignal* signal;
  int joint;  ///< joint index from 0

  auto of(const Recording& rows) const { return (rows.*signal->values).col(joint); }  ///< the values, one per row
  bool is(MatrixXd Recording::*values) const { return signal->values == values; }  ///< true: a channel of this signal
  const char* load_word() const { return is(&Recording::tau) ? "torque" : "current"; }
  Place place() const { return {signal->name, JointIndex{joint}}; }
  /// Text such as "joint 3 (tau3)".
  std::string name() const;
  /// Unit for a joint of unknown type, for example "N m or N".
  std::string unit() const;
};

/// The columns of a recording, signal by signal.
std::vector<Channel> channels_of(const Recording& rows);

/// A piece of the recording; rows before `fresh` have been processed.
struct Piece {
  const Recording& rows;
  int fresh;
};

/// The first rows, without absurd numbers, and scales computed from them.
struct Head {
  explicit Head(const Recording& recording);
  /// Recorded torques and currents of the joints that move.
  std::vector<Channel> moving_loads() const;

  const Recording& rows;
  double step = 0.0;        // [s] median time step
  double shortest = 0.0;    // [s] 1 % quantile of the steps
  double longest = 0.0;     // [s] 99 % quantile of the steps
  std::vector<bool> moves;  // true for the joints that move
  std::vector<bool> stale;  // true for rows that equal the row before while the arm moves
};

/// Number of rows in a window of QualityNumbers::window [s].
int window_rows(const Head& head);

/// A number as text: four significant digits; shares as "12 %"; counts as "1 row", "2 rows".
std::string number(double value);
std::string percent(double share);  ///< two digits
std::string counted(long count, const std::string& noun);  ///< "3 rows"

using Column = Eigen::Ref<const VectorXd>;

/// The value below which the given share (0 to 1) of the finite values lies; NaN if there are none.
double quantile(std::vector<double> values, double share);
/// True if quantile(values, share) > bound; it does not sort the values.
bool quantile_exceeds(const std::vector<double>& values, double share, double bound);
/// The distance between two quantiles.
double between_quantiles(std::vector<double> values, double low, double high);
/// Range of a column between its quantiles `ends` and 1 - `ends`, so that single wrong values do not count.
double range_of(const Column& values);
/// Sizes of a column's changes from row to row, zeros excluded; and its smallest usual change, 0 if nothing
/// changes.
std::vector<double> changes_of(const Column& values);
double resolution_of(const Column& values);  ///< a low quantile of the changes between values; 0: they never change
double share_of(long count, long rows);  ///< count / rows

/// True if row k equals row k - 1 in every signal although the arm moves.
bool is_stale(const Recording& rows, int k);
/// True if a velocity of row k is not zero; without velocities, if a position has changed within 6 rows.
bool is_moving(const Recording& rows, int k);
/// Mean product of a position's successive steps: > 0 if it moves in one direction from row to row, whereas the
/// noise of a resting joint alternates in sign.
double mean_step_product(const Column& q);

/// Processes every row of a recording and then reports.
class Tally {
 public:
  virtual ~Tally() = default;
  virtual void add(const Piece& piece) = 0;  ///< rows in order of time
  virtual void conclude(Findings* findings) const = 0;  ///< adds findings on all rows
};

/// Finds irregular time steps, other rates and missing rows.
std::unique_ptr<Tally> time_tally(const Head& head);
/// Finds stale rows, gaps, constant signals, and positions in degrees.
std::unique_ptr<Tally> row_tally(const Head& head);
/// Finds position steps that the neighbouring motion cannot explain.
std::unique_ptr<Tally> jump_tally(const Head& head);
/// Finds torques or currents that stay at their extreme value.
std::unique_ptr<Tally> clip_tally(const Head& head);

void check_motion(const Head& head, Findings* findings);
void check_velocities(const Head& head, Findings* findings);
/// Delay of dq behind the derivative of q [s], if significant.
std::optional<double> velocity_delay(const Head& head, int joint);
void check_stale_signals(const Head& head, Findings* findings);
void check_saturated_plateaus(const Head& head, Findings* findings);
/// Reports torques and currents whose changes are all larger than a share of their range.
void check_torque_steps(const Head& head, Findings* findings);
void check_start_up(const Head& head, Findings* findings);

}  // namespace veridyn::quality
