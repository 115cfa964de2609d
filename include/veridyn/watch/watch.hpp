#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "veridyn/effects/cause.hpp"
#include "veridyn/recordings/recording.hpp"

namespace veridyn {

struct WatchOptions {
  double learn = 4.0;       ///< [s] quiet beginning in which the noise is learned and nothing is told
  double learn_more = 32.0; ///< [s] until which it goes on being learned while nothing happens
  double false_alarms = 1.0;  ///< alarms per hour that a quiet arm may give
  double step = 0.1;          ///< [s] over which residuals are averaged
  double longest_naming = 5.0;  ///< [s] from an alarm until a cause is named, or told as doubtful
  double refine = 5.0;          ///< [s] after a cause was named, in which its size is refined
  std::vector<std::string> links;  ///< frames that may take up a load; empty: bodies and last frames
};

/// What became of a change.
enum class WatchStage {
  kSuspected,  ///< something changed; causes are still being told apart
  kNamed,      ///< a cause explains it
  kRefined,    ///< the same with more data
  kOver,       ///< a contact that has ended
};
const char* name_of(WatchStage stage);

/// One cause that explains a change about as well as the one that is named.
struct WatchRival {
  Cause cause;
  std::string text;        ///< its text form, "payload:tool"
  double evidence = 0.0;   ///< log-likelihood that it lacks of the best one
};

/// One line of what a watch says.
struct WatchEvent {
  int id = 0;  ///< counts changes; stages of one change have the same
  WatchStage stage = WatchStage::kSuspected;
  double time = 0.0;   ///< [s] when it is said
  double since = 0.0;  ///< [s] since when it is so
  double until = 0.0;  ///< [s] kOver: until when it was so
  Cause cause;         ///< best guess; ExternalContact for a push
  std::string text;    ///< its text form, "viscous_friction:yaw"
  double value = 0.0, low = 0.0, high = 0.0;  ///< size with its 95 % interval
  std::string unit;
  double strength = 0.0;   ///< statistic over its threshold when it was first seen
  std::vector<WatchRival> rivals;
  std::string sentence;  ///< for a technician
};

/// Where a watch stands, for pages and topics.
struct WatchState {
  double time = 0.0;     ///< [s] of the last step
  bool learning = true;
  bool alarmed = false;  ///< a change is being told apart
  double strength = 0.0; ///< largest statistic over its threshold
  std::string suspect;   ///< its cause
  VectorXd residual;     ///< (n) mean of the step: measured minus modelled torque, known changes taken off
  VectorXd torque;       ///< (n) measured
  VectorXd position;     ///< (n) [rad], [m] at the end of the step
  VectorXd noise;        ///< (n) standard deviation of a step's innovation
};

/// Follows a running arm against its MODEL and says what changed.
///
/// Rows are put on a uniform grid and smoothed; every step the torque that the model does not explain
/// and the columns of all hypotheses (offset, friction, gain, encoder zero of every joint; a mass on
/// every link) are averaged. A quiet beginning gives what is different today (offset and friction,
/// which no day has from the day before), the colour of what is left (an autoregression for every
/// joint) and how much more than white its innovations scatter. From then on every hypothesis has
/// least squares in information form with three forgetting factors,
///
///   A <- f A + x' x,   b <- f b + x' e,   S = b^2 / A
///
/// (x, e whitened), and an alarm is an S beyond the quantile of Fisher's F of the rate of false
/// alarms asked for. What changed is then told apart by the likelihood ratio since each
/// hypothesis' own best onset; a push from outside is what no lasting cause explains and what ends.
/// The size of what was named is taken off the residual, and the watch goes on.
///
///   Watch watch(read_model("psm.yaml"));
///   for (const WatchEvent& event : watch.add(rows)) ...
///
/// Source: Basseville and Nikiforov, Detection of Abrupt Changes, 1993 (generalized likelihood
/// ratio); Ljung, System Identification, 1999, 11.2 (forgetting).
class Watch {
 public:
  /// @throws InvalidInput  the model lacks values, a link is no frame, an option cannot be.
  explicit Watch(const Model& arm, const WatchOptions& options = {});
  ~Watch();
  Watch(Watch&&) noexcept;
  Watch& operator=(Watch&&) noexcept;

  /// Quiet recordings known beforehand: noise is learned from them, and nothing is told.
  /// To be called before add(), each time with a whole recording.
  void learn(const Recording& quiet);

  /// The next rows, of any number. Rows with gaps, and rows that a late publisher wrote twice, are
  /// passed over; a pause of more than half a second begins a new stretch.
  /// @throws InvalidInput  another number of joints, neither torques nor currents with drive gains.
  std::vector<WatchEvent> add(const Recording& rows);

  /// What is still open at the end of the rows.
  std::vector<WatchEvent> finish();

  const WatchState& state() const;
  /// Called after every step with where the watch then stands; for plots.
  void on_step(std::function<void(const WatchState&)> call);
  const Model& arm() const;
  /// All events so far.
  const std::vector<WatchEvent>& events() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> own_;
};

}  // namespace veridyn
