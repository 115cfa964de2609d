#include "diagnosis/watch/change.hpp"

#include <algorithm>
#include <cmath>

#include "identification/estimation/least_squares.hpp"
#include "veridyn/effects/cause.hpp"
#include "veridyn/effects/effect.hpp"
#include "math/student_t.hpp"

namespace veridyn::watching {

ChangeFinder::ChangeFinder(const Model& arm, const std::vector<Hypothesis>& hypotheses,
                           const WatchOptions& options, const WatchNumbers& numbers)
    : numbers_(numbers), arm_(arm), hypotheses_(hypotheses), options_(options),
      noise_(arm, hypotheses, numbers), quantiles_(static_cast<int>(hypotheses.size()), 3, numbers),
      known_(VectorXd::Zero(hypotheses.size())) {
  for (const double seconds : {numbers.short_memory, numbers.middle_memory, numbers.long_memory}) {
    Memory m;
    m.seconds = seconds;
    m.forgetting = 1.0 - options.step / seconds;
    m.A = m.b = VectorXd::Zero(known_.size());
    memories_.push_back(m);
  }
  // The constant offset, which acts independently of the motion.
  for (int j = 0; j < arm.joints(); ++j) {
    for (size_t h = 0; h < hypotheses.size(); ++h) {
      const Hypothesis& one = hypotheses[h];
      if (!one.along_axis() || one.of.joint->value != j) continue;
      const EffectTraits t = find_effect(effect_of(one.of.cause)).traits();
      if (!t.uses_velocity && !t.uses_position && !t.uses_acceleration && !t.depends_on_time)
        offset_of_joint_.push_back(static_cast<int>(h));
    }
  }
}

void ChangeFinder::learn(const std::vector<Step>& quiet) {
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
  for (const Step& step : all) {
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
  if (refining_) refine(white, step.time);
  detect(step.time, state);
  if (open_) isolate(step.time, false);
  update_noise(step, state.strength);
  state.residual = noise_.rest(step, known_);
  state.noise = noise_.deviation();
  state.alarmed = open_.has_value();
}

// Continues learning while nothing changes, and whenever the arm makes an unseen motion.
void ChangeFinder::update_noise(const Step& step, double strength) {
  const bool relearning = step.time < relearn_until_;
  if (open_ || (!relearning && (refining_ || strength >= 1.0))) return;
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

// Sizes for which the columns hold, or that a joint can have.
void ChangeFinder::set_bounds() {
  largest_ = VectorXd::Constant(known_.size(), 1e300);
  double mass = 0.0;  // no arm carries more than its own mass
  for (const Frame& f : arm_.frames())
    if (f.body && f.body->phi) mass += std::abs((*f.body->phi)[0]);
  for (Eigen::Index h = 0; h < known_.size(); ++h) {
    const Hypothesis& one = hypotheses_[h];
    if (is_load(one.of)) {
      largest_[h] = one.companion ? 0.0 : mass;
      continue;
    }
    const int joint = one.of.joint ? one.of.joint->value : 0;
    const Coordinate& c = arm_.coordinates()[joint];
    const Effect& effect = find_effect(effect_of(one.of.cause));
    const EffectParameter p = effect.parameters().front();
    largest_[h] = c.prismatic ? p.largest_prismatic : p.largest_revolute;
    if (!one.along_axis()) continue;
    const bool viscous = effect.traits().affine && effect.traits().uses_velocity;
    largest_[h] = numbers_.largest_torques * noise_.scale()[joint] / (viscous ? numbers_.slow : 1.0);
  }
  least_ = -largest_;
  for (Eigen::Index h = 0; h < known_.size(); ++h) {  // friction does not fall below zero
    const Hypothesis& one = hypotheses_[h];
    if (!one.along_axis()) continue;
    const Effect& effect = find_effect(effect_of(one.of.cause));
    if (!effect.traits().uses_velocity) continue;
    const VectorXd axis = VectorXd::Unit(arm_.joints(), one.of.joint->value);
    double whole = noise_.daily_offsets()[h] + known_[h];
    for (const EffectTerm& term : arm_.effects()) {
      const auto value = term.values.find(effect.parameters().front().name);
      if (term.effect == effect.name() && term.axis.coefficients == axis && value != term.values.end())
        whole += value->second;
    }
    least_[h] = std::max(least_[h], -std::max(whole, 0.0));
  }
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
  const double odds = quantiles_.dispersion() * numbers_.odds;
  if (c.score.gain < odds * numbers_.present_odds) return;
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
  WatchEvent e = event(c, WatchStage::kPresent, now);
  add_rivals(all, c.score, e);
  emit(std::move(e));
  if (hypotheses_[c.score.hypothesis].along_axis()) return;
  for (Step& step : quiet_)
    step.residual -= step.columns(Eigen::all, c.score.columns) * c.score.size;
  compensate(c.score, 1.0);
  c.named = now;
  past_.push_back(c);
  calibrate();
}

void ChangeFinder::detect(double now, WatchState& state) {
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
  if (open_ || above_ < numbers_.above_in_a_row || now < refractory_until_) return;
  if (refining_ && retest_cause(now)) return;
  if (refining_) {  // values from the refinement are kept
    past_.push_back(*refining_);
    refining_.reset();
  }
  Change c;
  c.id = ++ids_;
  c.alarm = now;
  c.strength = state.strength;
  c.lookback = 2.0 * memories_[memory].seconds + 0.5;
  c.score = best_onset(recent_, hypothesis, least_[hypothesis], largest_[hypothesis],
                       now - c.lookback, now);
  open_ = c;
  emit(event(c, WatchStage::kSuspected, now));
}

// Every hypothesis with its own best onset, the most likely first.
std::vector<Score> ChangeFinder::scores(const Change& change,
                                        const std::deque<WhiteStep>& steps) const {
  std::vector<Score> out;
  const double price = quantiles_.dispersion() * std::log(static_cast<double>(steps.size()));
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

void ChangeFinder::isolate(double now, bool last) {
  const double earliest = open_->alarm - open_->lookback;
  const std::vector<Score> scores = this->scores(*open_, recent_);
  const Score& best = scores.front();
  const double odds = quantiles_.dispersion() * numbers_.odds;
  const double price = quantiles_.dispersion() * std::log(static_cast<double>(recent_.size()));
  const Push lasting = best_push(recent_, offset_of_joint_, earliest, open_->alarm, 0.0, price, numbers_);
  const Push ended = best_push(recent_, offset_of_joint_, earliest, open_->alarm, numbers_.push_ends, price, numbers_);
  const bool still = ended.gain + odds > lasting.gain;  // no significant residual after its end
  if (still && ended.gain > best.gain + odds) {
    report_ended_push(ended, now);
    return;
  }
  const bool late = last || now - open_->alarm >= options_.longest_naming;
  const bool explained = is_explained(best);
  if (late && !explained) {
    report_ended_push(lasting.gain > 0.0 ? lasting : best_push(recent_, offset_of_joint_, earliest, now, 0.0, 0.0, numbers_), now);
    return;
  }
  const Cause& likeliest = hypotheses_[best.hypothesis].of.cause;
  double next = still ? ended.gain : 0.0;  // of another effect
  for (const Score& s : scores) {
    if (effect_of(hypotheses_[s.hypothesis].of.cause) == effect_of(likeliest)) continue;
    next = std::max(next, s.gain);
    break;
  }
  const bool likely = explained && best.gain - next > odds;
  const bool soon = now - best.onset < numbers_.soonest_name;
  if (late || (likely && !soon)) name(scores, now);
}

// True if little is left of the innovations since the onset, and the size differs from zero. The step of the change mixes
// both states.
bool ChangeFinder::is_explained(const Score& score) const {
  const Score fit = reestimated(recent_, score, numbers_.mixed * options_.step, numbers_);
  if (fit.size.size() == 0 || std::abs(fit.size[0]) <= half_width(fit)) return false;
  double before = 0.0, after = 0.0;
  for (auto step = recent_.rbegin(); step != recent_.rend() && step->time >= score.onset + numbers_.mixed * options_.step; ++step) {
    before += step->e.squaredNorm();
    after += (step->e - step->X(Eigen::all, fit.columns) * fit.size).squaredNorm() - quantiles_.dispersion() * static_cast<double>(step->e.size());
  }
  return after < numbers_.unexplained * before;
}

double ChangeFinder::half_width(const Score& score) const {
  // Quantities learned while quiet are inexact as well, and columns are of first order.
  const double learned = options_.step * static_cast<double>(before_.size() + quiet_.size());
  const double since = std::max(0.0, recent_.empty() ? 0.0 : recent_.back().time - score.onset);
  const double random = student_t_quantile(kOutside, quantiles_.freedom()) *
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

WatchEvent ChangeFinder::event(const Change& c, WatchStage stage, double now) const {
  const Hypothesis& h = hypotheses_[c.score.hypothesis];
  WatchEvent e;
  e.id = c.id;
  e.stage = stage;
  e.time = now;
  e.since = c.score.onset;
  e.until = now;
  e.cause = h.of.cause;
  e.value = c.score.size.size() > 0 ? c.score.size[0] : 0.0;
  const double half = half_width(c.score);
  e.low = e.value - half;
  e.high = e.value + half;
  e.unit = h.unit;
  e.strength = c.strength;
  return e;
}

void ChangeFinder::add_rivals(const std::vector<Score>& scores, const Score& best,
                              WatchEvent& e) const {
  const double phi = quantiles_.dispersion();
  for (const Score& s : scores) {
    if (s.hypothesis == best.hypothesis || best.gain - s.gain > phi * numbers_.odds) continue;
    const Cause& other = hypotheses_[s.hypothesis].of.cause;
    e.rivals.push_back({other, to_text(arm_, other), 0.5 * (best.gain - s.gain) / phi});
  }
}

void ChangeFinder::name(const std::vector<Score>& scores, double now) {
  Change c = *open_;
  open_.reset();
  c.score = reestimated(recent_, scores.front(), numbers_.mixed * options_.step, numbers_);
  c.named = now;
  WatchEvent e = event(c, WatchStage::kNamed, now);
  add_rivals(scores, c.score, e);
  // The same change with the opposite sign: it was reverted.
  const double size = c.score.size[0];
  const auto before = std::find_if(past_.rbegin(), past_.rend(), [&](const Change& p) {
    return p.score.hypothesis == c.score.hypothesis &&
           std::abs(p.score.size[0] + size) < 0.5 * std::abs(p.score.size[0]);
  });
  if (before != past_.rend()) {
    e = event(*before, WatchStage::kOver, now);
    e.until = c.score.onset;
    compensate(before->score, -1.0);
    past_.erase(std::next(before).base());
  } else {
    compensate(c.score, 1.0);
    c.seen = recent_;
    refining_ = std::move(c);
  }
  emit(std::move(e));
  reset();
  refractory_until_ = now + numbers_.refractory_time;
}

void ChangeFinder::report_ended_push(const Push& push, double now) {
  const Change c = *open_;
  open_.reset();
  const int j = push.last_joint ? push.last_joint->value : 0;
  const Coordinate& joint = arm_.coordinates()[j];
  WatchEvent e = event(c, now - push.to < numbers_.push_ends ? WatchStage::kUnnamed : WatchStage::kOver, now);
  e.cause = ExternalContact{{j}};
  e.since = push.from;
  e.until = push.to;
  e.value = push.torque.size() > j ? push.torque[j] : 0.0;
  const double steps = std::max(1.0, (push.to - push.from) / options_.step);
  const double half = student_t_quantile(kOutside, quantiles_.freedom()) * noise_.deviation()[j] *
                      std::sqrt(std::max(1.0, quantiles_.dispersion()) / steps);
  e.low = e.value - half;
  e.high = e.value + half;
  e.unit = effort_unit(joint);
  emit(std::move(e));
  reset();
  refractory_until_ = now + numbers_.refractory_time;
}

void ChangeFinder::refine(const WhiteStep& white, double now) {
  Change& c = *refining_;
  const MatrixXd X = white.X(Eigen::all, c.score.columns);
  c.seen.push_back(white);
  c.seen.back().e += X * c.score.size;
  if (retest_cause(now)) return;
  c.score.A += X.transpose() * X;
  compensate(c.score, -1.0);
  c.score.size += normal_solution(c.score.A, X.transpose() * white.e);
  compensate(c.score, 1.0);
  if (now - *c.named < options_.refine) return;
  emit(event(c, WatchStage::kRefined, now));
  past_.push_back(c);
  refining_.reset();
}

// Withdraws the name if the steps since make another cause more likely, at the odds of a name, and
// opens the change again.
bool ChangeFinder::retest_cause(double now) {
  Change& c = *refining_;
  if (c.withdrawn) return false;
  const std::vector<Score> all = scores(c, c.seen);
  const auto same = std::find_if(all.begin(), all.end(), [&](const Score& s) {
    return s.hypothesis == c.score.hypothesis;
  });
  if (all.front().gain - same->gain <= quantiles_.dispersion() * numbers_.odds) return false;
  emit(event(c, WatchStage::kWithdrawn, now));
  compensate(c.score, -1.0);
  open_ = std::move(c);
  refining_.reset();
  recent_.swap(open_->seen);
  open_->seen.clear();
  open_->withdrawn = true;
  open_->named.reset();
  return true;
}

void ChangeFinder::jump(const PositionJump& jump, double now) {
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
  WatchEvent e = event(c, WatchStage::kNamed, std::max(now, jump.time));
  const double half = student_t_quantile(kOutside, quantiles_.freedom()) * jump.noise;
  e.low = jump.size - half;
  e.high = jump.size + half;
  emit(std::move(e));
  refractory_until_ = jump.time + numbers_.refractory_time;
}

// Changes suspected since the last usable row are attributed to the unusable rows.
void ChangeFinder::discard_suspicion(const Blindness& blindness) {
  WatchEvent e;
  e.stage = WatchStage::kBlind;
  e.time = blindness.time;
  e.since = blindness.since;
  if (open_ && open_->alarm >= blindness.since) {
    e.id = open_->id;
    open_.reset();
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
  if (open_) isolate(now, true);
  if (refining_) {
    emit(event(*refining_, WatchStage::kRefined, now));
    past_.push_back(*refining_);
    refining_.reset();
  }
}

void ChangeFinder::emit(WatchEvent e) {
  e.text = to_text(arm_, e.cause);
  events_.push_back(std::move(e));
}

std::vector<WatchEvent> ChangeFinder::take_events() {
  std::vector<WatchEvent> out;
  out.swap(events_);
  return out;
}

}  // namespace veridyn::watching
