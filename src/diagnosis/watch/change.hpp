#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "veridyn/diagnosis/watch.hpp"
#include "diagnosis/watch/evidence.hpp"
#include "diagnosis/watch/noise.hpp"
#include "diagnosis/watch/smoothed_rows.hpp"

namespace veridyn::watching {

/// A change that was detected, from its suspicion to its refined size.
struct Change {
  int id = 0;
  Score score;            ///< least squares since the onset
  double alarm = 0.0;     ///< [s]
  double strength = 0.0;
  double lookback = 0.0;  ///< [s] before the alarm in which it may have begun
  std::optional<double> named = {};  ///< [s]
  bool withdrawn = false;  ///< its first name was; no second one, so that two causes do not alternate
  std::deque<WhiteStep> steps = {};  ///< since before the alarm; it is not subtracted from them
};

/// From steps to events: estimates the noise, raises alarms, isolates causes, subtracts known changes.
class ChangeFinder {
 public:
  ChangeFinder(const Model& arm, const std::vector<Hypothesis>& hypotheses,
               const WatchOptions& options, const WatchNumbers& numbers);

  void learn_quiet_steps(const std::vector<Step>& quiet);  ///< steps of another day or time in which nothing changed
  void add(const Step& step, WatchState& state);  ///< the next step, in order of time; sets suspect and strength
  void add_jump(const PositionJump& jump, double now);  ///< adds an event for a jump of an encoder
  void discard_suspicion(const Blindness& blindness);  ///< reports the time without usable rows
  /// The clock was set back: open changes are reported, as at the end, and all estimates are kept.
  void restart_clock(const Blindness& blindness, double now);
  void finish(double now);  ///< isolates and closes the open change, after the last step
  std::vector<WatchEvent> take_events();  ///< events since the last call
  bool learning() const { return learning_; }  ///< true until thresholds are known

 private:
  void calibrate();  ///< fits noise and thresholds to the quiet steps
  void set_bounds();
  void report_present_cause(double now);
  void add_rivals(const std::vector<Score>& scores, const Score& best, WatchEvent& e) const;
  void detect_change(double now, WatchState& state);  ///< raises an alarm if a statistic stays above its threshold
  void update_noise(const Step& step, double strength);
  void isolate_change(double now, bool last);  ///< names the open change, calls it a push, or waits; `last`: it cannot wait
  std::vector<Score> scores(const Change& change, const std::deque<WhiteStep>& steps) const;  ///< the largest gain first
  void name_change(const std::vector<Score>& scores, double now);  ///< names the first score as the cause
  void report_push(const Push& push, double now);
  void refine_change(double now);
  bool withdraw_name(double now);
  void close_change(double now, bool report);  ///< moves the open change to past_
  void reset();
  double push_price() const;
  double odds() const { return quantiles_.dispersion() * numbers_.odds; }
  bool is_suspected() const { return change_ && !change_->named; }
  Score score_after_transient(const Score& score) const;
  bool explains_change(const Score& score) const;
  double half_width(const Score& score) const;  ///< of the interval of the first size
  double own_value(const Hypothesis& one) const;
  double quantile() const;  ///< half width of an interval in standard deviations
  static void set_size(WatchEvent& e, double value, double half);
  void compensate(const Score& score, double share);  ///< adds a share of the sizes to the known changes
  WatchEvent make_event(const Change& change, WatchStage stage, double now) const;  ///< of a change at the time now [s]
  void store_event(WatchEvent e);  ///< stores an event for take_events()

  const WatchNumbers& numbers_;
  Model arm_;
  std::vector<Hypothesis> hypotheses_;
  WatchOptions options_;
  NoiseModel noise_;
  std::vector<Memory> memories_;
  Quantiles quantiles_;
  std::vector<Step> before_, quiet_;  // of other days; of today
  VectorXd least_, largest_;          // (hypotheses) sizes that each can have
  double unseen_motion_ = 0.0;                // [s] of new motion since the last calibration
  double relearn_until_ = -1e300;     // [s] new motion is learned until then
  double quiet_live_ = 0.0, calibrated_at_ = 0.0;
  bool learning_ = true;
  std::deque<WhiteStep> recent_;
  VectorXd known_;
  std::vector<int> offset_of_joint_;
  int above_ = 0, ids_ = 0;
  double last_learned_ = -1e300;  // [s]
  double refractory_until_ = -1e300;  // [s]
  std::optional<Change> change_;  // that is suspected, or was named and is being refined
  std::vector<Change> past_;
  std::vector<WatchEvent> events_;
};

}  // namespace veridyn::watching
