#include "veridyn/diagnosis/watch.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "math/numbers.hpp"
#include "recordings/velocity_trust.hpp"
#include "veridyn/math/require.hpp"
#include "diagnosis/watch/change.hpp"
#include "diagnosis/watch/event_words.hpp"
#include "diagnosis/watch/evidence.hpp"
#include "diagnosis/watch/smoothed_rows.hpp"
#include "diagnosis/watch/watch_numbers.hpp"

namespace veridyn {
namespace {

using watching::Change;
using watching::ChangeFinder;
using watching::Step;

void check(const WatchOptions& o, const WatchNumbers& numbers) {
  for (const double value : {o.learn, o.learn_more, o.step, o.false_alarms, o.longest_naming}) {
    require(value > 0.0 && std::isfinite(value), "watch: found a time or a rate of ", value,
            ", expected a number above zero.");
  }
  require(o.refine >= 0.0 && std::isfinite(o.refine), "watch: found ", o.refine, " s to refine a cause in, expected 0 or more.");
  require(o.learn_more >= o.learn, "watch: found ", o.learn_more, " s to learn more in, expected ", o.learn, " s or more.");
  require(o.step < numbers.short_memory, "watch: found steps of ", o.step, " s, expected less than ", numbers.short_memory,
          " s, the shortest memory.");
}

void require_same_signals(const Recording& before, const Recording& rows) {
  for (const RecordingSignal& signal : kRecordingSignals) {
    const Eigen::Index expected = (before.*signal.values).cols(), found = (rows.*signal.values).cols();
    require(before.rows() == 0 || found == expected, rows.source, ": found ", found, " columns ", signal.name, ", expected ", expected, " as in the rows before.");
  }
}

// [s] from the earliest to the latest of the times that are numbers.
double duration_of(const VectorXd& time) {
  double earliest = kInfinity, latest = -kInfinity;
  for (const double t : time) {
    if (!std::isfinite(t)) continue;
    earliest = std::min(earliest, t);
    latest = std::max(latest, t);
  }
  return latest - earliest;
}

}  // namespace

class Watch::Implementation {
 public:
  /// Faults that the recorded signals have from the first row on.
  struct Signals {
    std::set<JointIndex> wrong_velocities;  ///< joints whose velocity is no derivative of the position
    watching::RowClock clock;
    std::vector<std::string> remarks;
  };

  Implementation(const Model& arm, const WatchOptions& options, const WatchNumbers& numbers)
      : numbers_(numbers), arm_(arm), options_(options), rows_(arm, numbers_),
        hypotheses_(arm, options.links, options.step, numbers_), finder_(arm, hypotheses_.all(), options, numbers_) {
    check(options, numbers_);
    state_.residual = state_.torque = state_.noise = VectorXd::Zero(arm.joints());
    rows_.on_row = [this](const watching::SmoothedRow& row) {
      const std::optional<Step> step = hypotheses_.add(row, rows_.dt(), rows_.spacing());
      if (!step) return;
      now_ = step->time;
      finder_.add(*step, state_);
      state_.time = clock().recorded_time(now_);
      if (on_step_) on_step_(state_);
    };
    rows_.on_break = [this] { hypotheses_.restart(); };
    rows_.on_blind = [this](const watching::Blindness& b) {
      if (b.set_back <= 0.0) {
        finder_.discard_suspicion(b);
        return;
      }
      finder_.restart_clock(b, now_);
      now_ -= b.set_back;
      state_.set_back += clock().factor * b.set_back;
      state_.alarmed = false;
    };
    rows_.on_jump = [this](const watching::PositionJump& jump) { finder_.add_jump(jump, now_); };
  }

  void learn(const Recording& quiet) {
    const std::vector<Step> all = steps_of(quiet, judged_signals(quiet));
    require(static_cast<double>(all.size()) * options_.step > numbers_.middle_memory, quiet.source, ": found less than two seconds of usable rows, expected a quiet recording.");
    finder_.learn_quiet_steps(all);
  }

  std::vector<WatchEvent> add(const Recording& rows) {
    if (rows.rows() > 0) rows_.check(rows);
    if (judged_) {
      watch(rows);
    } else if (rows.rows() > 0) {
      require_same_signals(unassessed_, rows);
      append(unassessed_, rows);
      if (duration_of(unassessed_.time) >= 0.5 * options_.learn && unassessed_.rows() >= numbers_.rows_for_step) assess_signals();
    }
    note_blindness();
    return take_events();
  }

  std::vector<WatchEvent> finish() {
    assess_signals();
    rows_.finish();
    finder_.finish(now_);
    note_blindness();
    return take_events();
  }

  void note_blindness() {
    state_.heard = clock().recorded_time(rows_.last_row_time());
    state_.blind = clock().factor * rows_.blind();
  }

  // Events have the times of the rows' clock.
  std::vector<WatchEvent> take_events() {
    std::vector<WatchEvent> out = finder_.take_events();
    for (WatchEvent& e : out) {
      for (double* time : {&e.time, &e.since, &e.until}) *time = clock().recorded_time(*time);
      e.sentence = e.stage == WatchStage::kBlind ? watching::blind_sentence(e, e.sentence) : watching::sentence(e);
    }
    events_.insert(events_.end(), out.begin(), out.end());
    return out;
  }

  // Without recorded velocities where one of them is wrong: all are then derived from the positions.
  static Recording with_sound_velocities(Recording rows, const Signals& signals) {
    if (!signals.wrong_velocities.empty()) rows.dq.resize(0, 0);
    return rows;
  }

  void watch(const Recording& rows) {
    rows_.add(with_sound_velocities(rows, signals_));
    if (!finder_.learning()) rows_.enable_jump_detection();
  }

  // Decides once, before the noise is learned, which velocities and which clock are used.
  void assess_signals() {
    if (judged_) return;
    judged_ = true;
    if (unassessed_.rows() > 0) {
      signals_ = judged_signals(unassessed_);
      rows_.set_clock(clock());
      watch(unassessed_);
    }
    unassessed_ = {};
  }

  const watching::RowClock& clock() const { return signals_.clock; }

  Signals judged_signals(const Recording& rows) const {
    Signals out;
    if (rows.rows() == 0) return out;
    const RecordingQuality quality = check_recording(rows);
    if (rows.dq.size() > 0) out.wrong_velocities = trust_in_velocities({quality}).wrong;
    out.remarks = remarks_on(out.wrong_velocities, arm_);
    if (const QualityFinding* unit = quality.find(QualityKind::kTimeUnit)) out.remarks.push_back(unit->sentence);
    const QualityFinding* off = quality.find(QualityKind::kRateContradiction);
    if (off == nullptr) return out;
    // Velocities contradict positions on all joints: the model says whether the clock is wrong or the velocities are.
    Signals other_clock = out, other_unit = out;
    other_clock.clock = {rows.time[0], off->value};
    for (int j = 0; j < arm_.joints(); ++j) other_unit.wrong_velocities.insert({j});
    const bool is_clock = residual_share(rows, other_clock) < residual_share(rows, other_unit);
    (is_clock ? other_clock : other_unit).remarks.push_back(text(off->sentence, " The model agrees with ", is_clock ? "that rate, which is used." : "the rows' clock and with the derivative of the positions, which is used."));
    return is_clock ? other_clock : other_unit;
  }

  // Squares that the model leaves of the torques, by those of the torques.
  double residual_share(const Recording& rows, const Signals& signals) const {
    double left = 0.0, whole = 0.0;
    for (const Step& step : steps_of(rows, signals)) {
      left += step.residual.squaredNorm();
      whole += step.torque.squaredNorm();
    }
    return whole > 0.0 ? left / whole : kInfinity;
  }

  // Steps of recorded rows under an assumption about their clock and velocities, outside of the running watch.
  std::vector<Step> steps_of(const Recording& recorded, const Signals& signals) const {
    watching::SmoothedRows rows(arm_, numbers_);
    watching::Hypotheses hypotheses(arm_, options_.links, options_.step, numbers_);
    std::vector<Step> all;
    rows.set_clock(signals.clock);
    rows.on_row = [&](const watching::SmoothedRow& row) {
      if (const std::optional<Step> step = hypotheses.add(row, rows.dt(), rows.spacing())) all.push_back(*step);
    };
    rows.on_break = [&] { hypotheses.restart(); };
    rows.add(with_sound_velocities(recorded, signals));
    return all;
  }

  WatchNumbers numbers_;  // the parts below refer to it
  Model arm_;
  WatchOptions options_;
  Recording unassessed_;  // first rows, until their signals are judged
  bool judged_ = false;
  Signals signals_;
  watching::SmoothedRows rows_;
  watching::Hypotheses hypotheses_;
  ChangeFinder finder_;
  WatchState state_;
  std::vector<WatchEvent> events_;
  std::function<void(const WatchState&)> on_step_;
  double now_ = 0.0;
};

Watch::Watch(const Model& arm, const WatchOptions& options) : Watch(arm, options, WatchNumbers()) {}
Watch::Watch(const Model& arm, const WatchOptions& options, const WatchNumbers& numbers)
    : own_(std::make_unique<Implementation>(arm, options, numbers)) {}
Watch::~Watch() = default;
Watch::Watch(Watch&&) noexcept = default;
Watch& Watch::operator=(Watch&&) noexcept = default;

void Watch::learn(const Recording& quiet) { own_->learn(quiet); }
std::vector<WatchEvent> Watch::add(const Recording& rows) { return own_->add(rows); }
std::vector<WatchEvent> Watch::finish() { return own_->finish(); }
const WatchState& Watch::state() const { return own_->state_; }
void Watch::on_step(std::function<void(const WatchState&)> call) { own_->on_step_ = std::move(call); }
const Model& Watch::arm() const { return own_->arm_; }
const std::vector<WatchEvent>& Watch::events() const { return own_->events_; }
const std::vector<std::string>& Watch::remarks() const { return own_->signals_.remarks; }

const char* name_of(WatchStage stage) {
  constexpr const char* kNames[] = {"suspected", "named", "unnamed", "refined", "over", "present", "withdrawn", "blind"};
  return kNames[static_cast<size_t>(stage)];
}

}  // namespace veridyn
