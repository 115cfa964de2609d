#include "veridyn/diagnosis/watch.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "math/numbers.hpp"
#include "recordings/velocity_trust.hpp"
#include "veridyn/math/require.hpp"
#include "math/student_t.hpp"
#include "diagnosis/watch/change.hpp"
#include "diagnosis/watch/evidence.hpp"
#include "diagnosis/watch/smoothed_rows.hpp"
#include "diagnosis/watch/step_builder.hpp"
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

Recording joined(const Recording& before, const Recording& rows) {
  if (before.rows() == 0) return rows;
  Recording out = before;
  out.time.resize(before.rows() + rows.rows());
  out.time << before.time, rows.time;
  for (const RecordingSignal& signal : kRecordingSignals) {
    const MatrixXd& first = before.*signal.values;
    const MatrixXd& then = rows.*signal.values;
    MatrixXd& all = out.*signal.values;
    require(first.cols() == then.cols(), rows.source, ": found ", then.cols(), " columns ", signal.name,
            ", expected ", first.cols(), " as in the rows before.");
    all.resize(first.rows() + then.rows(), first.cols());
    if (all.size() > 0) all << first, then;
  }
  return out;
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

std::set<int> wrong_velocities(const Recording& rows) {
  if (rows.dq.size() == 0) return {};
  return trust_in_velocities({check_recording(rows)}).wrong;
}

// Without recorded velocities where one of them is wrong: all are then derived from the positions.
Recording with_sound_velocities(Recording rows, const std::set<int>& wrong) {
  if (!wrong.empty()) rows.dq.resize(0, 0);
  return rows;
}

}  // namespace

class Watch::Implementation {
 public:
  Implementation(const Model& arm, const WatchOptions& options, const WatchNumbers& numbers)
      : numbers_(numbers), arm_(arm), options_(options), rows_(arm, numbers_), hypotheses_(arm, options.links, numbers_),
        steps_(hypotheses_, options.step), finder_(arm, hypotheses_.all(), options, numbers_) {
    check(options, numbers_);
    state_.residual = state_.torque = state_.noise = VectorXd::Zero(arm.joints());
    rows_.on_row = [this](const watching::SmoothedRow& row) { steps_.add(row, rows_.dt()); };
    rows_.on_break = [this] { steps_.restart(); };
    rows_.on_blind = [this](const watching::Blindness& b) {
      if (b.set_back <= 0.0) {
        finder_.discard_suspicion(b);
        return;
      }
      finder_.restart_clock(b, now_);
      now_ -= b.set_back;
      state_.set_back += b.set_back;
      state_.alarmed = false;
    };
    rows_.on_jump = [this](const watching::PositionJump& jump) { finder_.jump(jump, now_); };
    steps_.on_step = [this](const Step& step) {
      now_ = step.time;
      finder_.add(step, state_);
      if (told_) told_(state_);
    };
  }

  void learn(const Recording& recorded) {
    const Recording quiet = with_sound_velocities(recorded, wrong_velocities(recorded));
    watching::SmoothedRows rows(arm_, numbers_);
    watching::Hypotheses hypotheses(arm_, options_.links, numbers_);
    watching::StepBuilder steps(hypotheses, options_.step);
    std::vector<Step> all;
    rows.on_row = [&](const watching::SmoothedRow& row) { steps.add(row, rows.dt()); };
    rows.on_break = [&] { steps.restart(); };
    steps.on_step = [&](const Step& step) { all.push_back(step); };
    rows.add(quiet);
    require(static_cast<double>(all.size()) * options_.step > numbers_.middle_memory, quiet.source, ": found less than two seconds of usable rows, expected a quiet recording.");
    finder_.learn(all);
  }

  std::vector<WatchEvent> add(const Recording& rows) {
    if (rows.rows() > 0) rows_.check(rows);
    if (judged_) {
      watch(rows);
    } else if (rows.rows() > 0) {
      unassessed_ = joined(unassessed_, rows);
      if (duration_of(unassessed_.time) >= numbers_.judged * options_.learn && unassessed_.rows() >= numbers_.rows_for_step) assess_velocities();
    }
    note_blindness();
    return take_events();
  }

  std::vector<WatchEvent> finish() {
    assess_velocities();
    rows_.finish();
    finder_.finish(now_);
    note_blindness();
    return take_events();
  }

  void note_blindness() {
    state_.heard = rows_.last_row_time();
    state_.blind = rows_.blind();
  }

  std::vector<WatchEvent> take_events() {
    std::vector<WatchEvent> out = finder_.take_events();
    events_.insert(events_.end(), out.begin(), out.end());
    return out;
  }

  void watch(const Recording& rows) {
    rows_.add(with_sound_velocities(rows, wrong_));
    if (!finder_.learning()) rows_.enable_jump_detection();
  }

  // Decides once whether recorded velocities are used, before the noise is learned.
  void assess_velocities() {
    if (judged_) return;
    judged_ = true;
    wrong_ = wrong_velocities(unassessed_);
    remarks_ = remarks_on(wrong_, arm_);
    if (unassessed_.rows() > 0) {
      const RecordingQuality quality = check_recording(unassessed_);
      for (const char* clock : {"time_unit", "rate_contradiction"}) {
        if (const QualityFinding* off = quality.find(clock)) remarks_.push_back(off->sentence);
      }
      watch(unassessed_);
    }
    unassessed_ = {};
  }

  WatchNumbers numbers_;  // the parts below refer to it
  Model arm_;
  WatchOptions options_;
  Recording unassessed_;  // first rows, until the velocities are judged
  bool judged_ = false;
  std::set<int> wrong_;  // joints, from 0, whose velocity is no derivative of the position
  std::vector<std::string> remarks_;
  watching::SmoothedRows rows_;
  watching::Hypotheses hypotheses_;
  watching::StepBuilder steps_;
  ChangeFinder finder_;
  WatchState state_;
  std::vector<WatchEvent> events_;
  std::function<void(const WatchState&)> told_;
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
void Watch::on_step(std::function<void(const WatchState&)> call) { own_->told_ = std::move(call); }
const Model& Watch::arm() const { return own_->arm_; }
const std::vector<WatchEvent>& Watch::events() const { return own_->events_; }
const std::vector<std::string>& Watch::remarks() const { return own_->remarks_; }

const char* name_of(WatchStage stage) {
  switch (stage) {
    case WatchStage::kSuspected: return "suspected";
    case WatchStage::kNamed: return "named";
    case WatchStage::kUnnamed: return "unnamed";
    case WatchStage::kRefined: return "refined";
    case WatchStage::kOver: return "over";
    case WatchStage::kPresent: return "present";
    case WatchStage::kWithdrawn: return "withdrawn";
    case WatchStage::kBlind: return "blind";
  }
  return "";
}

}  // namespace veridyn
