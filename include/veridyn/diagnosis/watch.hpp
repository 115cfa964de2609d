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
  /// [s] at the beginning, during which the noise is estimated and nothing is reported
  double learn = 4.0;
  double learn_more = 32.0; ///< [s] up to which the noise estimate is refined while nothing changes
  double false_alarms = 1.0;  ///< false alarms per hour on an arm without changes
  double step = 0.1;          ///< [s] over which residuals are averaged
  /// [s] after an alarm, at which the best cause is reported in any case
  double longest_naming = 5.0;
  double refine = 5.0;  ///< [s] after the isolation, in which the size of the cause is refined
  /// Frames that a load may be added to; empty: bodies and last frames.
  std::vector<std::string> links;
};

/// Stage of a detected change.
enum class WatchStage {
  kSuspected,  ///< detected; causes are still being separated
  kNamed,      ///< isolated: one cause explains it
  kUnnamed,    ///< isolated: no single cause explains it, or a push that has not ended; its cause is an ExternalContact
  kRefined,    ///< the same size estimated from more data
  kOver,       ///< a contact that has ended
  kPresent,    ///< a difference from the model at the beginning; it is part of the reference and raises no alarm
  kWithdrawn,  ///< the isolated cause was wrong: another one explains more and follows with the same id
  /// The rows are unusable from this time on: none arrive, they are not finite, their times do not increase,
  /// or rows or a torque stay constant while the arm moves. Also if their clock was set back; later events
  /// then have the new times. It has no cause. Its id is that of a change that was suspected at this time, or
  /// 0.
  kBlind,
};
const char* name_of(WatchStage stage);

/// An alternative cause with nearly the same likelihood.
struct WatchRival {
  Cause cause;
  std::string text;        ///< its text form, "payload:tool"
  double evidence = 0.0;   ///< difference of its log-likelihood from that of the best cause
};

/// One event of a watch.
struct WatchEvent {
  int id = 0;  ///< number of the change; its stages share it
  WatchStage stage = WatchStage::kSuspected;
  double time = 0.0;   ///< [s] of the report
  double since = 0.0;  ///< [s] estimated onset
  double until = 0.0;  ///< [s] kOver: estimated end
  Cause cause;         ///< the most likely cause; ExternalContact for a push
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
  double blind = 0.0;    ///< [s] in which the watch had no usable rows, see WatchStage::kBlind
  double set_back = 0.0; ///< [s] by which the clock of the rows was set back
  double strength = 0.0; ///< largest statistic divided by its threshold
  std::string suspect;   ///< cause with that statistic
  /// (n) mean over the step: measured minus modelled torque, known changes compensated
  VectorXd residual;
  VectorXd torque;       ///< (n) measured
  VectorXd position;     ///< (n) [rad], [m] at the end of the step
  VectorXd noise;        ///< (n) standard deviation of the innovation of a step
};

/// Fault detection and isolation on a running arm: compares it with its model and reports changes.
///
/// Rows are resampled on a uniform grid and smoothed; in every step the residual torque and the
/// columns of all hypotheses (offset, friction, gain, encoder zero of every joint; a mass on every
/// link) are averaged. The first seconds give the parameters that vary from day to day (offset and
/// friction), the spectrum of the residual (an autoregression for every joint) and the
/// overdispersion of its innovations. Afterwards every hypothesis is fitted by least squares in
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

  /// Estimates the noise from a recording without changes; reports nothing. Call it before add(), once for each
  /// whole recording.
  void learn(const Recording& quiet);

  /// Processes the next rows and returns their events. Rows whose time does not increase, and repeated rows,
  /// are skipped. A pause of more than half a second begins a new segment, as does a clock that was set back,
  /// which is recognised after a quarter of a second. The noise estimate and the isolated changes are kept.
  /// @throws InvalidInput  another number of joints, neither torques nor currents with drive gains, or other
  /// signals than in the previous rows.
  std::vector<WatchEvent> add(const Recording& rows);

  /// Reports changes that have not ended at the end of the rows.
  std::vector<WatchEvent> finish();

  const WatchState& state() const;
  /// Sets a function that is called after every step with the state of the watch; for plots.
  void on_step(std::function<void(const WatchState&)> call);
  const Model& arm() const;
  /// Sentences on joints whose recorded velocity is not the derivative of the position, and on a wrong clock. They are
  /// found in the first half of the learning time; all velocities are then derived from the positions, or times are
  /// those of the clock that the model agrees with. Events and states keep the times of the rows.
  const std::vector<std::string>& remarks() const;
  /// All events so far.
  const std::vector<WatchEvent>& events() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> own_;
};

}  // namespace veridyn
