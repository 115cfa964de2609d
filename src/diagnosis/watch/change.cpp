#include "diagnosis/watch/change.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "identification/estimation/least_squares.hpp"
#include "veridyn/effects/cause.hpp"
#include "veridyn/effects/effect.hpp"
#include "math/student_t.hpp"

namespace veridyn::watching {

ChangeFinder::ChangeFinder(const Model& arm, const std::vector<Hypothesis>& hypotheses,
                           const WatchOptions& options, const WatchNumbers& numbers)
    : numbers_(numbers), arm_(arm), hypotheses_(hypotheses), options_(options),
      noise_(arm, hypotheses, numbers), quantiles_(static_cast<int>(hypotheses.size()), 3, numbers),
      least_(VectorXd::Zero(hypotheses.size())), largest_(least_), known_(least_) {
  for (const double seconds : {numbers.short_memory, numbers.middle_memory, numbers.long_memory}) {
    Memory m;
    m.seconds = seconds;
    m.forgetting = 1.0 - options.step / seconds;
    m.A = m.b = VectorXd::Zero(known_.size());
    memories_.push_back(m);
  }
  for (size_t h = 0; h < hypotheses.size(); ++h) {
    if (!hypotheses[h].along_axis()) continue;
    const EffectTraits t = hypotheses[h].traits();
    if (!t.uses_velocity && !t.uses_position && !t.uses_acceleration && !t.depends_on_time) offset_of_joint_.push_back(static_cast<int>(h));
  }
}

void ChangeFinder::learn_quiet_steps(const std::vector<Step>& quiet) {
  NoiseModel own(arm_, hypotheses_, numbers_);
  own.fit({}, quiet);
  for (const Step& step : quiet) {
    before_.push_back(step);
    before_.back().residual = own.rest(step, VectorXd::Zero(known_.size()));
  }
}

void ChangeFinder::reset() {
  for (Memory& m : memories_) m.clear();
  recent_.clear();
  above_ = 0;
}

// Fits the noise of the quiet steps, and the statistics along them.
void ChangeFinder::calibrate() {
  noise_.fit(before_, quiet_);
  set_bounds();
  reset();
  unseen_motion_ = 0.0;
  MatrixXd sum = MatrixXd::Zero(known_.size(), static_cast<Eigen::Index>(memories_.size()));
  VectorXd counts = VectorXd::Zero(sum.cols());
  std::vector<Step> all = before_;
  for (Step& step : all) step.residual += step.columns * noise_.daily_offsets();
  all.insert(all.end(), quiet_.begin(), quiet_.end());
  for (Step& step : all) {
    step.residual += step.columns * known_;  // which was taken from them, and whitening takes it again, as from the steps to come
    const WhiteStep white = noise_.whiten(step, known_);
    recent_.push_back(white);
    for (size_t m = 0; m < memories_.size(); ++m) {
      const auto i = static_cast<Eigen::Index>(m);
      if (!step.follows) memories_[m].clear();
      memories_[m].add(white);
      sum.col(i) += memories_[m].statistics(least_, largest_);
      counts[i] += 1.0;
    }
  }
  while (recent_.size() > static_cast<size_t>(numbers_.recent / options_.step)) recent_.pop_front();
  for (Eigen::Index m = 0; m < sum.cols(); ++m) sum.col(m) /= std::max(counts[m], 1.0);
  quantiles_.learn(sum, memories_, options_.step * static_cast<double>(all.size()),
                   options_.false_alarms);
  calibrated_at_ = quiet_live_;
}

void ChangeFinder::add(const Step& step, WatchState& state) {
  state.time = step.time;
  state.torque = step.torque;
  state.position = step.position;
  if (learning_) {
    quiet_.push_back(step);
    quiet_live_ += options_.step;
    state.residual = step.residual;
    if (quiet_live_ >= options_.learn - 0.5 * options_.step) {
      learning_ = false;
      calibrate();
      report_present_cause(step.time);
    }
    state.learning = learning_;
    return;
  }
  state.learning = step.time < relearn_until_;
  const WhiteStep white = noise_.whiten(step, known_);
  if (!step.follows) {
    reset();
    refractory_until_ = step.time + numbers_.refractory_time;
  }
  recent_.push_back(white);
  if (recent_.size() > static_cast<size_t>(numbers_.recent / options_.step)) recent_.pop_front();
  for (Memory& m : memories_) m.add(white);
  if (change_) {
    change_->steps.push_back(white);
    if (change_->named) change_->steps.back().e += white.X(Eigen::all, change_->score.columns) * change_->score.size;
  }
  if (change_ && change_->named) refine_change(step.time);
  detect_change(step.time, state);
  if (is_suspected()) isolate_change(step.time, false);
  update_noise(step, state.strength);
  state.residual = noise_.rest(step, known_);
  state.noise = noise_.deviation();
  state.alarmed = is_suspected();
}

// Continues learning while nothing changes, and whenever the arm makes an unseen motion.
void ChangeFinder::update_noise(const Step& step, double strength) {
  const bool relearning = step.time < relearn_until_;
  if (is_suspected() || (!relearning && (change_ || strength >= 1.0))) return;
  const bool novel = noise_.novel(step);
  unseen_motion_ = novel ? unseen_motion_ + options_.step : std::max(0.0, unseen_motion_ - options_.step);
  if (!relearning && unseen_motion_ >= numbers_.unseen_motion) {  // the arm began an unseen motion
    relearn_until_ = refractory_until_ = step.time + options_.learn;
    unseen_motion_ = 0.0;
  }
  if (!novel && !relearning && (!past_.empty() || quiet_live_ >= options_.learn_more)) return;
  quiet_.push_back(step);
  quiet_.back().residual -= step.columns * known_;
  quiet_.back().follows = step.follows && step.time - last_learned_ < kFollows * options_.step;
  last_learned_ = step.time;
  quiet_live_ += options_.step;
  if (static_cast<int>(quiet_.size()) > numbers_.most_quiet) quiet_.erase(quiet_.begin());
  const bool more = past_.empty() && quiet_live_ >= 2.0 * calibrated_at_ &&
                    quiet_live_ <= options_.learn_more;
  const bool learned = relearning && step.time + kFollows * options_.step >= relearn_until_;
  if (learned || (more && !relearning)) calibrate();
}

// Sets the largest plausible size of every hypothesis: a load weighs no more than the arm, friction does not fall below zero,
// and the linearised columns of other causes hold up to the largest value of their effect.
void ChangeFinder::set_bounds() {
  double mass = 0.0;
  for (const Frame& f : arm_.frames()) {
    if (f.body && f.body->phi) mass += std::abs((*f.body->phi)[0]);
  }
  for (Eigen::Index h = 0; h < known_.size(); ++h) {
    const Hypothesis& one = hypotheses_[h];
    const int joint = one.of.joint ? one.of.joint->value : 0;
    if (is_load(one.of)) {
      largest_[h] = one.companion ? 0.0 : mass;
    } else if (one.along_axis()) {
      largest_[h] = numbers_.largest_torques * noise_.scale()[joint] / one.speed(numbers_.slow);
    } else {
      const EffectParameter p = find_effect(effect_of(one.of.cause)).parameters().front();
      largest_[h] = arm_.coordinates()[joint].prismatic ? p.largest_prismatic : p.largest_revolute;
    }
    least_[h] = -largest_[h];
    if (one.along_axis() && one.traits().uses_velocity) least_[h] = std::max(least_[h], -std::max(noise_.daily_offsets()[h] + known_[h] + own_value(one), 0.0));
  }
}

// Value of the model's own effect with the cause and joint of a hypothesis; 0 without one.
double ChangeFinder::own_value(const Hypothesis& one) const {
  const Effect& effect = find_effect(effect_of(one.of.cause));
  double out = 0.0;
  for (const EffectTerm& term : arm_.effects()) {
    const auto value = term.values.find(effect.parameters().front().name);
    if (term.effect == effect.name() && term.axis.coefficients == VectorXd::Unit(arm_.joints(), one.of.joint->value) && value != term.values.end()) out += value->second;
  }
  return out;
}

// The cause that explains most of the quiet beginning's residual, if its torque matters. What the
// differences of a day cannot absorb, such as a load, counts as known from then on.
void ChangeFinder::report_present_cause(double now) {
  std::deque<WhiteStep> whole;
  for (const Step& step : quiet_) whole.push_back(noise_.whiten(step, -noise_.daily_offsets()));
  Change c;
  c.alarm = quiet_.front().time;
  c.lookback = options_.step;
  const std::vector<Score> all = scores(c, whole);
  c.score = all.front();
  if (c.score.gain < odds() * numbers_.present_odds) return;
  VectorXd power = VectorXd::Zero(arm_.joints());
  double before = 0.0, after = 0.0;
  for (const Step& step : quiet_) {
    const VectorXd torque = step.columns(Eigen::all, c.score.columns) * c.score.size;
    power += torque.cwiseAbs2() / static_cast<double>(quiet_.size());
    before += step.residual.cwiseQuotient(noise_.scale().cwiseMax(kNothing)).squaredNorm();
    after += (step.residual - torque).cwiseQuotient(noise_.scale().cwiseMax(kNothing)).squaredNorm();
  }
  if (after > numbers_.present_share * before) return;
  const VectorXd share = power.cwiseSqrt().cwiseQuotient(noise_.scale().cwiseMax(kNothing));
  if (share.maxCoeff() < numbers_.present_share || std::abs(c.score.size[0]) <= half_width(c.score)) return;
  c.id = ++ids_;
  WatchEvent e = make_event(c, WatchStage::kPresent, now);
  add_rivals(all, c.score, e);
  store_event(std::move(e));
  if (hypotheses_[c.score.hypothesis].along_axis()) return;
  for (Step& step : quiet_)
    step.residual -= step.columns(Eigen::all, c.score.columns) * c.score.size;
  compensate(c.score, 1.0);
  c.named = now;
  past_.push_back(c);
  calibrate();
}

void ChangeFinder::detect_change(double now, WatchState& state) {
  state.strength = 0.0;
  int hypothesis = -1;
  size_t memory = 0;
  for (size_t m = 0; m < memories_.size(); ++m) {
    const VectorXd strength =
        memories_[m].statistics(least_, largest_).cwiseQuotient(quantiles_.threshold(static_cast<int>(m)));
    Eigen::Index at = 0;
    const double most = strength.maxCoeff(&at);
    if (most <= state.strength) continue;
    state.strength = most;
    hypothesis = static_cast<int>(at);
    memory = m;
  }
  state.suspect = hypothesis >= 0 ? to_text(arm_, hypotheses_[hypothesis].of.cause) : "";
  above_ = state.strength > 1.0 ? above_ + 1 : 0;
  if (is_suspected() || above_ < numbers_.above_in_a_row || now < refractory_until_) return;
  if (change_ && withdraw_name(now)) return;
  close_change(now, false);
  Change c;
  c.id = ++ids_;
  c.alarm = now;
  c.strength = state.strength;
  c.lookback = 2.0 * memories_[memory].seconds + 0.5;
  c.score = best_onset(recent_, hypothesis, least_[hypothesis], largest_[hypothesis],
                       now - c.lookback, now);
  c.steps = recent_;
  change_ = c;
  store_event(make_event(c, WatchStage::kSuspected, now));
}

// Every hypothesis with its own best onset, the most likely first.
std::vector<Score> ChangeFinder::scores(const Change& change,
                                        const std::deque<WhiteStep>& steps) const {
  std::vector<Score> out;
  const double price = quantiles_.dispersion() * std::log(static_cast<double>(steps.size()));  // of a column
  for (int h = 0; h < static_cast<int>(hypotheses_.size()); ++h) {
    const Hypothesis& one = hypotheses_[h];
    if (one.companion) continue;
    const Score alone = best_onset(steps, h, least_[h], largest_[h],
                                   change.alarm - change.lookback, change.alarm);
    Score whole = with_companions(steps, alone, one.companions, price, numbers_);
    // First moments without a mass are no load.
    const Score later = reestimated(steps, whole, numbers_.mixed * options_.step, numbers_);
    const bool load = whole.columns.size() < 2 || std::abs(later.size[0]) > half_width(later);
    out.push_back(load ? std::move(whole) : alone);
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const Score& a, const Score& b) { return a.gain > b.gain; });
  return out;
}

// Price of one torque for half a second of a push.
double ChangeFinder::push_price() const { return quantiles_.dispersion() * std::log(static_cast<double>(change_->steps.size())); }

void ChangeFinder::isolate_change(double now, bool last) {
  const double earliest = change_->alarm - change_->lookback;
  const std::vector<Score> scores = this->scores(*change_, change_->steps);
  const Score& best = scores.front();
  const auto push = [&](double latest, double still, double price) {
    return best_push(change_->steps, offset_of_joint_, earliest, latest, still, price, numbers_);
  };
  const Push lasting = push(change_->alarm, 0.0, push_price()), ended = push(change_->alarm, numbers_.push_ends - 0.5 * options_.step, push_price());
  const bool still = ended.gain + odds() > lasting.gain;  // no significant residual after its end
  if (still && ended.gain > best.gain + odds()) {
    report_push(ended, now);
    return;
  }
  const bool late = last || now - change_->alarm >= options_.longest_naming;
  const bool explained = explains_change(best);
  if (late && !explained) {
    report_push(lasting.gain > 0.0 ? lasting : push(now, 0.0, 0.0), now);
    return;
  }
  const auto effect = [this](const Score& s) { return effect_of(hypotheses_[s.hypothesis].of.cause); };
  const auto other = std::find_if(scores.begin(), scores.end(), [&](const Score& s) { return effect(s) != effect(best); });
  const double next = std::max(still ? ended.gain : 0.0, other == scores.end() ? 0.0 : other->gain);
  const bool likely = explained && best.gain - next > odds() && now - best.onset >= numbers_.soonest_name;
  if (late || likely) name_change(scores, now);
}

// The score without the step of the change, which mixes both states.
Score ChangeFinder::score_after_transient(const Score& score) const {
  return reestimated(change_->steps, score, numbers_.mixed * options_.step, numbers_);
}

// True if the cause leaves little of the innovations since the onset, and its size differs from zero.
bool ChangeFinder::explains_change(const Score& score) const {
  const Score fit = score_after_transient(score);
  if (fit.size.size() == 0 || std::abs(fit.size[0]) <= half_width(fit)) return false;
  double before = 0.0, after = 0.0;
  const std::deque<WhiteStep>& steps = change_->steps;  // the first ones may be of another day, with later times
  for (auto step = steps.rbegin(); step != steps.rend() && step->time >= score.onset + numbers_.mixed * options_.step; ++step) {
    before += step->e.squaredNorm();
    after += (step->e - step->X(Eigen::all, fit.columns) * fit.size).squaredNorm() - quantiles_.dispersion() * static_cast<double>(step->e.size());
  }
  return after < numbers_.unexplained * before;
}

double ChangeFinder::half_width(const Score& score) const {
  // Quantities learned while quiet are inexact as well, and columns are of first order.
  const double learned = options_.step * static_cast<double>(before_.size() + quiet_.size());
  const double since = std::max(0.0, recent_.empty() ? 0.0 : recent_.back().time - score.onset);
  const double random = quantile() *
                        std::sqrt(std::max(1.0, quantiles_.dispersion()) *
                                  (1.0 + since / std::max(learned, options_.step))) *
                        score.deviation();
  const double size = score.size.size() > 0 ? score.size[0] : 0.0;
  return std::hypot(random, numbers_.systematic * size);
}

void ChangeFinder::compensate(const Score& score, double share) {
  for (size_t p = 0; p < score.columns.size(); ++p)
    known_[score.columns[p]] += share * score.size[static_cast<Eigen::Index>(p)];
}

// @param half  half the width of the interval.
void ChangeFinder::set_size(WatchEvent& e, double value, double half) {
  e.value = value;
  e.low = value - half;
  e.high = value + half;
}

double ChangeFinder::quantile() const { return student_t_quantile(kOutside, quantiles_.freedom()); }

WatchEvent ChangeFinder::make_event(const Change& c, WatchStage stage, double now) const {
  const Hypothesis& h = hypotheses_[c.score.hypothesis];
  WatchEvent e;
  e.id = c.id;
  e.stage = stage;
  e.time = now;
  e.since = c.score.onset;
  e.until = now;
  e.cause = h.of.cause;
  set_size(e, c.score.size.size() > 0 ? c.score.size[0] : 0.0, half_width(c.score));
  e.unit = h.unit;
  e.strength = c.strength;
  return e;
}

void ChangeFinder::add_rivals(const std::vector<Score>& scores, const Score& best,
                              WatchEvent& e) const {
  for (const Score& s : scores) {
    if (s.hypothesis == best.hypothesis || best.gain - s.gain > odds()) continue;
    const Cause& other = hypotheses_[s.hypothesis].of.cause;
    e.rivals.push_back({other, to_text(arm_, other), 0.5 * (best.gain - s.gain) / quantiles_.dispersion()});
  }
}

void ChangeFinder::name_change(const std::vector<Score>& scores, double now) {
  Change& c = *change_;
  c.score = score_after_transient(scores.front());
  c.named = now;
  WatchEvent e = make_event(c, WatchStage::kNamed, now);
  add_rivals(scores, c.score, e);
  // The same change with the opposite sign: it was reverted.
  const double size = c.score.size[0];
  const auto before = std::find_if(past_.rbegin(), past_.rend(), [&](const Change& p) {
    return p.score.hypothesis == c.score.hypothesis &&
           std::abs(p.score.size[0] + size) < 0.5 * std::abs(p.score.size[0]);
  });
  if (before != past_.rend()) {
    e = make_event(*before, WatchStage::kOver, now);
    e.until = c.score.onset;
    compensate(before->score, -1.0);
    past_.erase(std::next(before).base());
    change_.reset();
  } else {
    compensate(c.score, 1.0);
  }
  store_event(std::move(e));
  reset();
  refractory_until_ = now + numbers_.refractory_time;
}

void ChangeFinder::report_push(const Push& push, double now) {
  const int j = push.last_joint ? push.last_joint->value : 0;
  WatchEvent e = make_event(*change_, now - push.to < numbers_.push_ends - 0.5 * options_.step ? WatchStage::kUnnamed : WatchStage::kOver, now);
  change_.reset();
  e.cause = ExternalContact{{j}};
  e.since = push.from;
  e.until = push.to;
  const double steps = std::max(1.0, (push.to - push.from) / options_.step);
  set_size(e, push.torque.size() > j ? push.torque[j] : 0.0,
           quantile() * noise_.deviation()[j] * std::sqrt(std::max(1.0, quantiles_.dispersion()) / steps));
  e.unit = effort_unit(arm_.coordinates()[j]);
  store_event(std::move(e));
  reset();
  refractory_until_ = now + numbers_.refractory_time;
}

// Estimates the size of a named change again with every step, and tests its name.
void ChangeFinder::refine_change(double now) {
  if (withdraw_name(now)) return;
  Change& c = *change_;
  compensate(c.score, -1.0);
  c.score = score_after_transient(c.score);
  compensate(c.score, 1.0);
  if (now - *c.named >= options_.refine) close_change(now, true);
}

// A named change counts as known from now on.
void ChangeFinder::close_change(double now, bool report) {
  if (!change_) return;
  if (report) store_event(make_event(*change_, WatchStage::kRefined, now));
  change_->steps.clear();
  past_.push_back(*std::exchange(change_, std::nullopt));
}

// Withdraws the name if the steps since make another cause more likely, at the odds of a name, and
// opens the change again.
bool ChangeFinder::withdraw_name(double now) {
  Change& c = *change_;
  if (c.withdrawn) return false;
  const std::vector<Score> all = scores(c, c.steps);
  const auto same = std::find_if(all.begin(), all.end(), [&](const Score& s) {
    return s.hypothesis == c.score.hypothesis;
  });
  if (all.front().gain - same->gain <= odds()) return false;
  store_event(make_event(c, WatchStage::kWithdrawn, now));
  compensate(c.score, -1.0);
  recent_ = c.steps;
  c.withdrawn = true;
  c.named.reset();
  return true;
}

void ChangeFinder::add_jump(const PositionJump& jump, double now) {
  const auto slip = std::find_if(hypotheses_.begin(), hypotheses_.end(), [&](const Hypothesis& h) {
    return is_channel(h.of) && h.of.joint == JointIndex{jump.joint} &&
           find_effect(effect_of(h.of.cause)).traits().same_as_wrong_constant;
  });
  if (slip == hypotheses_.end()) return;
  Change c;
  c.id = ++ids_;
  c.score.hypothesis = static_cast<int>(slip - hypotheses_.begin());
  c.score.onset = jump.time;
  c.score.size = VectorXd::Constant(1, jump.size);
  c.strength = std::abs(jump.size) / std::max(jump.noise, 1e-300);
  WatchEvent e = make_event(c, WatchStage::kNamed, std::max(now, jump.time));
  set_size(e, jump.size, quantile() * jump.noise);
  store_event(std::move(e));
  refractory_until_ = jump.time + numbers_.refractory_time;
}

// Changes suspected since the last usable row are attributed to the unusable rows.
void ChangeFinder::discard_suspicion(const Blindness& blindness) {
  WatchEvent e;
  e.stage = WatchStage::kBlind;
  e.time = blindness.time;
  e.since = blindness.since;
  if (is_suspected() && change_->alarm >= blindness.since) {
    e.id = change_->id;
    change_.reset();
    reset();
  }
  e.sentence = blindness.why;
  events_.push_back(std::move(e));
}

void ChangeFinder::restart_clock(const Blindness& blindness, double now) {
  finish(now);
  discard_suspicion(blindness);
  for (double* time : {&relearn_until_, &refractory_until_}) *time -= blindness.set_back;
  last_learned_ = -1e300;
  for (Change& c : past_) c.score.onset -= blindness.set_back;
}

void ChangeFinder::finish(double now) {
  if (is_suspected()) isolate_change(now, true);
  close_change(now, true);
}

void ChangeFinder::store_event(WatchEvent e) {
  e.text = to_text(arm_, e.cause);
  events_.push_back(std::move(e));
}

std::vector<WatchEvent> ChangeFinder::take_events() {
  std::vector<WatchEvent> out;
  out.swap(events_);
  return out;
}

}  // namespace veridyn::watching
