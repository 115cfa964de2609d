#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "veridyn/effects/cause.hpp"
#include "veridyn/recordings/recording.hpp"

namespace veridyn {

struct WatchNumbers;

struct WatchOptions {
  /// [s] quiet beginning in which the noise is learned and nothing is reported
  double learn = 4.0;
  double learn_more = 32.0; ///< [s] until which learning continues while nothing changes
  double false_alarms = 1.0;  ///< false alarms per hour on an arm without changes
  double step = 0.1;          ///< [s] over which residuals are averaged
  /// [s] from an alarm until a cause is isolated, or reported as doubtful
  double longest_naming = 5.0;
  double refine = 5.0;  ///< [s] after the isolation, in which the size of the cause is refined
  /// Frames that a load may be added to; empty: bodies and last frames.
  std::vector<std::string> links;
};

/// Stage of a detected change.
enum class WatchStage {
  kSuspected,  ///< detected; causes are still being separated
  kNamed,      ///< isolated: one cause explains it
  kRefined,    ///< the same size estimated from more data
  kOver,       ///< a contact that has ended
  kPresent,    ///< there when the watch began: learned, and no reason for an alarm
  kWithdrawn,  ///< the name was wrong: another one explains more, and follows with the same id
  /// Nothing can be watched since: no rows, no finite numbers, times that do not rise, rows or a torque that
  /// stand still while the arm moves. Or the rows' clock was set back: later events have its new times. No
  /// change and no cause; the id is that of a change that was suspected since then, or 0.
  kBlind,
};
const char* name_of(WatchStage stage);

/// An alternative cause that explains a change about as well.
struct WatchRival {
  Cause cause;
  std::string text;        ///< its text form, "payload:tool"
  double evidence = 0.0;   ///< log-likelihood below that of the best cause
};

/// One event of a watch.
struct WatchEvent {
  int id = 0;  ///< number of the change; its stages share it
  WatchStage stage = WatchStage::kSuspected;
  double time = 0.0;   ///< [s] of the report
  double since = 0.0;  ///< [s] estimated onset
  double until = 0.0;  ///< [s] kOver: estimated end
  Cause cause;         ///< the most likely one; ExternalContact for a push
  std::string text;    ///< its text form, "viscous_friction:yaw"
  double value = 0.0, low = 0.0, high = 0.0;  ///< size with its 95 % interval
  std::string unit;
  double strength = 0.0;   ///< statistic divided by its threshold at the detection
  std::vector<WatchRival> rivals;
  std::string sentence;  ///< whole sentence for a technician
};

/// State of a watch, for pages and topics.
struct WatchState {
  double time = 0.0;     ///< [s] of the last step
  bool learning = true;
  bool alarmed = false;  ///< a change is being isolated
  double heard = 0.0;    ///< [s] of the last row, usable or not
  double blind = 0.0;    ///< [s] so far in which nothing could be watched, see WatchStage::kBlind
  double set_back = 0.0; ///< [s] by which the rows' clock was set back so far
  double strength = 0.0; ///< largest statistic divided by its threshold
  std::string suspect;   ///< cause with that statistic
  /// (n) mean over the step: measured minus modelled torque, known changes compensated
  VectorXd residual;
  VectorXd torque;       ///< (n) measured
  VectorXd position;     ///< (n) [rad], [m] at the end of the step
  VectorXd noise;        ///< (n) standard deviation of the innovation of a step
};

/// Fault detection and isolation on a running arm: compares it with its MODEL and reports changes.
///
/// Rows are resampled on a uniform grid and smoothed; in every step the residual torque and the
/// columns of all hypotheses (offset, friction, gain, encoder zero of every joint; a mass on every
/// link) are averaged. A quiet beginning gives the parameters that vary from day to day (offset and
/// friction), the spectrum of the residual (an autoregression for every joint) and the
/// overdispersion of its innovations. From then on every hypothesis has least squares in
/// information form with three forgetting factors,
///
///   A <- f A + x' x,   b <- f b + x' e,   S = b^2 / A
///
/// (x, e whitened), and an alarm is an S beyond the quantile of Fisher's F for the chosen rate of
/// false alarms. The change is then isolated by the likelihood ratio since each hypothesis' own
/// best onset; an external push is a change that no lasting cause explains and that ends. The
/// isolated change is subtracted from the residual, and the watch continues.
///
///   Watch watch(read_model("psm.yaml"));
///   for (const WatchEvent& event : watch.add(rows)) ...
///
/// Source: Basseville and Nikiforov, Detection of Abrupt Changes, 1993 (generalized likelihood
/// ratio); Ljung, System Identification, 1999, 11.2 (forgetting).
class Watch {
 public:
  /// @throws InvalidInput  the model lacks values, a link is no frame, or an option is out of
  /// range.
  explicit Watch(const Model& arm, const WatchOptions& options = {});
  /// @param numbers  thresholds in place of the default ones (`veridyn numbers` prints these).
  Watch(const Model& arm, const WatchOptions& options, const WatchNumbers& numbers);
  ~Watch();
  Watch(Watch&&) noexcept;
  Watch& operator=(Watch&&) noexcept;

  /// Learns the noise from quiet recordings without reporting anything. Call it before add(), each
  /// time with a whole recording.
  void learn(const Recording& quiet);

  /// Watches the next rows and returns the events that they bring. Rows whose time does not rise, or
  /// which are repeated, are skipped; a pause of more than half a second begins a new segment, and so does a
  /// clock that was set back, which takes a quarter of a second to be known. What was learned and named stays.
  /// @throws InvalidInput  another number of joints, neither torques nor currents with drive gains, other
  /// signals than in the rows before.
  std::vector<WatchEvent> add(const Recording& rows);

  /// Reports changes that are still open at the end of the rows.
  std::vector<WatchEvent> finish();

  const WatchState& state() const;
  /// Sets a function that is called after every step with the state of the watch; for plots.
  void on_step(std::function<void(const WatchState&)> call);
  const Model& arm() const;
  /// Joints whose recorded velocity is no derivative of the position, in words. They are found in
  /// the first half of the learning time; the watch then derives all velocities from the positions.
  const std::vector<std::string>& remarks() const;
  /// All events so far.
  const std::vector<WatchEvent>& events() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> own_;
};

}  // namespace veridyn
