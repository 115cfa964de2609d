#include "diagnosis/search/current_set.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "diagnosis/numerics.hpp"
#include "diagnosis/search/numbers.hpp"
#include "math/parallel.hpp"
#include "math/student_t.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/identification/base_parameters.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::search {
namespace {

// True if the columns of a term depend on the recorded motion alone, not on values or constants of the arm.
bool follows_motion(const Term& t) {
  if (t.kind == TermKind::kCurve)
    return std::none_of(t.signals.begin(), t.signals.end(), [](const Signal& s) { return s.kind == SignalKind::kTorque; });
  return (t.kind == TermKind::kEffect || t.kind == TermKind::kChange) && !find_effect(t.effect.effect).traits().uses_load;
}

// True if the columns of both are equal: same recorded motion, same torque gains.
bool is_same_motion(const Rows& a, const Rows& b) {
  for (int i = 0; i < a.joints(); ++i) {
    if (a.arm().coordinates()[i].recorded.torque_gain != b.arm().coordinates()[i].recorded.torque_gain) return false;
  }
  return std::equal(a.stretches().begin(), a.stretches().end(), b.stretches().begin(), b.stretches().end(), [](const Stretch& x, const Stretch& y) {
    return x.segment.q == y.segment.q && x.segment.dq == y.segment.dq && x.segment.ddq == y.segment.ddq;
  });
}

// Standard errors that a gain must reach where no held-out recording repeats its test.
double required_standard_errors(int blocks) {
  return blocks < kManyBlocks ? student_t_quantile(2.0 * (1.0 - kProbabilityWithoutTest), std::max(1.0, blocks - 1.0)) : kStandardErrorsWithoutTest;
}

}  // namespace

bool is_tilt(const Term& t) {
  return t.kind == TermKind::kChannel && dynamic_cast<const ArmEffect*>(&find_effect(t.effect.effect)) != nullptr &&
         !dynamic_cast<const ArmEffect&>(find_effect(t.effect.effect)).further_start_values().empty();
}

bool is_factor(const Term& t) {
  if (t.kind != TermKind::kChannel) return false;
  const auto* sensor = dynamic_cast<const SensorError*>(&find_effect(t.effect.effect));
  return sensor != nullptr && sensor->scales_torque();
}

CurrentSet::CurrentSet(const Model& arm, const SearchRequest& request) : arm_(arm), request_(request) {
  rows_ = std::make_shared<Rows>(arm, request.recordings, request.preprocessing, request.threads);
  folds_ = folds_of(*rows_, request.periods, request.preprocessing.cutoff, request.scope.poses ? 1.0 : kBlockSeconds);
  folds_.errors = is_repeated() ? kStandardErrorsWithTest : required_standard_errors(folds_.blocks);
  values_ = VectorXd(rows_->names().size());
  const std::vector<StandardParameter> all = standard_parameters(arm);
  for (Eigen::Index p = 0; p < values_.size(); ++p) values_[p] = all[p].value;
  directions_ = base_parameters(arm).size();
  base_ = base_of(*rows_);
  dictionary_ = search::dictionary(*rows_, request.scope);
  cache_.resize(dictionary_.size());
}

std::vector<int> CurrentSet::all_but(const std::set<size_t>& without) const {
  std::vector<int> out;
  for (size_t k = 0; k < terms.size(); ++k) {
    if (without.count(k) == 0) out.push_back(static_cast<int>(k));
  }
  return out;
}

Base CurrentSet::base_of(const Rows& rows) const {
  if (!request_.scope.changes) {
    // Under a leaning base more parameters have a torque, such as the first moments of an upright arm's first link.
    const double lean = (rows.arm().gravity() - arm_.gravity()).norm();
    const bool is_leaning = lean > 0.0 && lean < kSmallLean * arm_.gravity().norm();
    return fitted_base(rows, is_leaning ? base_parameters(rows.arm()).size() : directions_, request_.threads);
  }
  if (base_.T.size() == 0) return prior_base(rows, arm_);
  // The directions were determined at the MODEL's own arm; at a corrected arm their columns differ.
  Base out = base_;
  for (int i = 0; i < rows.joints(); ++i) out.X[i] = base_columns(rows, i, out.T);
  return out;
}

double CurrentSet::price_of(const std::vector<int>& some) const {
  double sum = 0.0;
  for (const int k : some) sum += terms[k].term.price;
  return sum;
}

// Curves on the joint of a named term. A curve can imitate the named cause, so that the term is compared
// without it.
std::set<size_t> CurrentSet::curves_beside(size_t k) const {
  std::set<size_t> out;
  const Term& t = terms[k].term;
  for (size_t c = 0; t.kind != TermKind::kCurve && t.joint && c < terms.size(); ++c) {
    if (terms[c].term.kind == TermKind::kCurve && terms[c].term.joint == t.joint) out.insert(c);
  }
  return out;
}

CurrentSet::State CurrentSet::snapshot() const { return {terms, rows_, base_, values_, weights_, cache_, test_, test_of_, test_columns_}; }

const std::shared_ptr<const Columns>& CurrentSet::columns_at(size_t k) {
  if (!cache_[k]) cache_[k] = std::make_shared<Columns>(columns_of(dictionary_[k], *rows_));
  return cache_[k];
}

Round CurrentSet::round() {
  std::vector<SetTerm> set;
  for (const Chosen& c : terms) set.push_back({&c.columns, c.ridge, c.term.nonnegative});
  return Round(*rows_, folds_, base_, set, weights_);
}

VectorXd CurrentSet::ridge_of(const Term& t, Eigen::Index count, const VectorXd& scale) const {
  VectorXd out = VectorXd::Zero(count);
  if (t.kind == TermKind::kCurve) out.setConstant(1.0 / std::pow(kCurveSize * scale[t.joint->value], 2));
  if (t.kind == TermKind::kLoad) {
    out.setConstant(1.0 / std::pow(t.mass == 0.0 ? kInertia : std::min(kInertia, std::abs(t.mass) * kGyration * kGyration), 2));
    out.segment<3>(1).setConstant(1.0 / std::pow(kMassOfArm * kReach, 2));
    out[0] = 1.0 / std::pow(kMassOfArm, 2);
  }
  return out;
}

bool CurrentSet::is_chosen(const Term& t, const std::set<size_t>& without) const {
  for (size_t k = 0; k < terms.size(); ++k) {
    if (without.count(k) != 0 || !same_place(terms[k].term, t)) continue;
    // Several memories or waves may act on one axis.
    if (t.kind == TermKind::kEffect && !t.shapes.empty() && find_effect(t.effect.effect).traits().memory) continue;
    return true;
  }
  return false;
}

bool CurrentSet::shares_joint(const Term& t, const std::set<size_t>& with) const {
  return !t.joint || std::any_of(with.begin(), with.end(), [&](size_t k) {
    return !terms[k].term.joint || terms[k].term.joint == t.joint;
  });
}

void CurrentSet::restore(const State& s) {
  terms = s.terms;
  rows_ = s.rows;
  base_ = s.base;
  values_ = s.values;
  weights_ = s.weights;
  cache_ = s.cache;
  test_ = s.test;
  test_of_ = s.test_of;
  test_columns_ = s.test_columns;
}

Model CurrentSet::arm_of(const std::vector<Chosen>& some) const {
  return corrected(request_.scope.changes ? arm_ : with_values(arm_, values_, VectorXd()), some);
}

bool CurrentSet::move_to(const Model& arm) {
  std::shared_ptr<Rows> rows;
  try {
    rows = std::make_shared<Rows>(arm, request_.recordings, request_.preprocessing, request_.threads);
  } catch (const InvalidInput&) {
    return false;  // no arm has these constants
  }
  if (rows->rows() != static_cast<Eigen::Index>(folds_.of_row.size()) || !rows->residual.allFinite()) return false;
  const bool same = is_same_motion(*rows_, *rows);
  rows_ = std::move(rows);
  for (size_t k = 0; k < cache_.size(); ++k) {
    if (!same || !follows_motion(dictionary_[k])) cache_[k] = nullptr;
  }
  parallel_for(static_cast<int>(terms.size()) + 1, request_.threads, [&](int k) {
    if (k == 0) base_ = base_of(*rows_);
    else if (!same || !follows_motion(terms[k - 1].term)) terms[k - 1].columns = columns_of(terms[k - 1].term, *rows_);
  });
  return true;
}

bool CurrentSet::linearise(size_t k) {
  bool moved = terms[k].gravity.has_value();
  if (moved && !move_to(arm_of(terms))) return false;
  std::optional<Round> now(round());
  for (int step = 0; step < kSteps; ++step) {
    const Fitted& fit = now->fit();
    const auto [first, count] = range(k);
    const VectorXd z = fit.x.segment(first, count);
    const MatrixXd covariance = now->covariance(now->whole(), fit, MatrixXd::Identity(fit.x.size(), fit.x.size()).middleRows(first, count));
    bool small = true;
    for (Eigen::Index c = 0; c < count; ++c) small = small && std::abs(z[c]) < kConvergedStep * std::sqrt(std::max(covariance(c, c), numerics::kTiny));
    if (small) return true;
    const State state = snapshot();
    std::optional<Round> better;
    // A torque computed from the recorded torque of another joint contains its noise, so that it need not
    // lower the score as much as the model's torque does. Under another gravity the hidden parameters of a
    // MODEL have a torque: each fitted one may raise the held-out error.
    double least = moved ? 0.0 : -kExchangeGain;
    if (!moved && is_tilt(terms[k].term)) least *= 1.0 + static_cast<double>(base_.hidden);
    if (!moved && terms[k].term.candidate.from) least = -kRivalGainShare * now->gain(fit, now->evaluate(now->subset(all_but({k})))).sum;
    for (double scale = 1.0; scale > kShortestStep && !better; scale *= 0.5) {
      std::vector<double> trial(static_cast<size_t>(count));
      for (Eigen::Index c = 0; c < count; ++c) trial[static_cast<size_t>(c)] = scale * z[c];
      if (!take_step(k, trial)) {
        terms = state.terms;
        continue;
      }
      if (!request_.scope.changes) values_ = state.values + state.base.T * fit.x.head(state.base.T.cols());
      if (move_to(arm_of(terms))) {
        Round then = round();
        const double gained = now->gain(then.fit(), fit).sum;
        if (gained > least) {
          if (gained < kNegligibleGain && step > 0) return true;
          better.emplace(std::move(then));
          continue;
        }
      }
      restore(state);
    }
    if (!better) return moved;
    now.emplace(std::move(*better));
    moved = true;
  }
  return true;
}

// Adds a step to the offset of a term.
bool CurrentSet::take_step(size_t k, const std::vector<double>& step) {
  Chosen& c = terms[k];
  if (is_tilt(c.term)) {
    const Model now = with_step(rows_->arm(), c.term, step);
    c.gravity = now.gravity();
    return true;
  }
  const auto& parameters = c.term.kind == TermKind::kChannel ? find_effect(c.term.effect.effect).parameters() : std::vector<EffectParameter>(1);
  for (size_t p = 0; p < step.size(); ++p) {
    double& offset = c.offset[p];
    offset = is_factor(c.term) ? (1.0 + offset) * (1.0 + step[p]) - 1.0 : offset + step[p];
    if (parameters[p].sign == ParameterSign::kNonnegative && c.term.kind == TermKind::kChannel) offset = std::max(offset, 0.0);
    if (is_factor(c.term) && offset < kSignReversingGain) return false;
    if (c.term.kind == TermKind::kConstant && std::abs(offset) > largest_change_of(*c.term.constant)) return false;
  }
  return true;
}

std::pair<Eigen::Index, Eigen::Index> CurrentSet::range(size_t k) const {
  Eigen::Index at = base_.T.cols();
  for (size_t c = 0; c < k; ++c) at += terms[c].columns.count();
  return {at, terms[k].columns.count()};
}

CurrentSet::LeaveOneOut CurrentSet::evaluate_without(size_t k, const Round& now, const Visitor& visitor) {
  LeaveOneOut out;
  std::set<size_t> aside = curves_beside(k);
  const std::vector<int> set = all_but(aside);
  out.with = aside.empty() ? now.fit() : now.evaluate(now.subset(set));
  const bool is_tested = is_repeated();
  MatrixXd test_with, test_without;
  if (is_tested) test_with = test_residual_of(out.with.x, set);
  aside.insert(k);
  if (!terms[k].term.is_linearised()) {
    const std::vector<int> rest = all_but(aside);
    const Subset s = now.subset(rest);
    out.fit = now.evaluate(s);
    if (is_tested) test_without = test_residual_of(out.fit.x, rest);
  } else {
    const State state = snapshot();
    terms.erase(terms.begin() + static_cast<long>(k));
    if (move_to(arm_of(terms))) {
      const Round then = round();
      out.fit = then.fit();
      if (is_tested) test_without = test_residual_of(out.fit.x, all_but({}));
      if (visitor) visitor(then, then.whole(), out.fit, then.gain(out.with, out.fit).sum);
    } else {
      out.fit = out.with;
      test_without = test_with;
    }
    restore(state);
  }
  out.gain = now.gain(out.with, out.fit);
  if (is_tested && test_with.rows() == test_without.rows()) out.on_test = gain_on(*test_rows(), test_with, test_without, now.samples_of_row());
  return out;
}

const std::shared_ptr<const Rows>& CurrentSet::test_rows() {
  if (test_of_ != rows_) {
    test_ = std::make_shared<Rows>(rows_->arm(), request_.test, request_.test_preprocessing, request_.threads);
    test_columns_.clear();
    test_of_ = rows_;
  }
  return test_;
}

MatrixXd CurrentSet::test_residual_of(const VectorXd& x, const std::vector<int>& set) {
  const Rows& test = *test_rows();
  MatrixXd residual = test.residual;
  const VectorXd shift = base_.T * x.head(base_.T.cols());
  for (int i = 0; i < rows_->joints(); ++i) residual.col(i) -= test.own[i] * shift(test.own_parameters[i]);
  std::vector<std::shared_ptr<const Columns>*> columns;
  std::vector<std::pair<const Term*, std::shared_ptr<const Columns>*>> missing;
  for (const int k : set) {
    const Term& t = terms[k].term;
    std::string key = t.place;
    for (const auto& [name, value] : t.effect.values) key += fmt::format(" {} {:.17g}", name, value);
    for (int e = 0; e < 3; ++e) key += fmt::format(" {:.17g}", t.centre[e]);
    const auto [at, is_new] = test_columns_.emplace(key, nullptr);
    columns.push_back(&at->second);
    if (is_new) missing.emplace_back(&t, &at->second);
  }
  parallel_for(static_cast<int>(missing.size()), request_.threads, [&](int k) {
    *missing[k].second = std::make_shared<Columns>(columns_of(*missing[k].first, test));
  });
  for (size_t at = 0; at < set.size(); ++at) {
    const auto [begin, count] = range(static_cast<size_t>(set[at]));
    const Columns& own = **columns[at];
    for (size_t j = 0; j < own.joints.size(); ++j) residual.col(own.joints[j]) -= own.of[j] * x.segment(begin, count);
  }
  return residual;
}

Model corrected(const Model& arm, const std::vector<Chosen>& chosen) {
  Model out = arm;
  for (const Chosen& c : chosen) {
    if (!c.term.is_linearised()) continue;
    if (c.gravity) {
      ModelDescription d = out.description();
      d.gravity = *c.gravity;
      out = Model(std::move(d));
    } else if (std::any_of(c.offset.begin(), c.offset.end(), [](double x) { return x != 0.0; })) {
      out = with_step(out, c.term, c.offset);
    }
  }
  return out;
}

}  // namespace veridyn::search
