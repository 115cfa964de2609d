#include "diagnosis/search/search.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <set>

#include "diagnosis/numerics.hpp"
#include "diagnosis/search/current_set.hpp"
#include "diagnosis/search/exchanges.hpp"
#include "diagnosis/search/numbers.hpp"
#include "diagnosis/search/outcome.hpp"
#include "math/student_t.hpp"

namespace veridyn::search {
namespace {

Chosen chosen_of(const Exchange& e) {
  Chosen c;
  c.term = e.term;
  c.columns = *e.columns;
  c.ridge = e.ridge;
  c.gravity = e.gravity;
  if (c.term.is_linearised()) c.offset.assign(static_cast<size_t>(c.columns.count()), 0.0);
  return c;
}

template <typename T>
void append(std::vector<T> more, std::vector<T>& to) {
  to.insert(to.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

class Search {
 public:
  Search(const Model& arm, const SearchRequest& request) : request_(request), current_(arm, request), exchanges_(current_, request) {}

  SearchResult run() {
    if (!current_.is_empty()) {
      begin_with_friction();
      // A curve can imitate any named cause on its joint: named terms come first, then curves next to them,
      // or in place of all named terms of a joint.
      int round = 0;
      const int most = kRounds + request_.most;
      const auto has_room = [&] { return static_cast<int>(current_.terms.size()) < request_.most && round < most; };
      do {
        for (; has_room(); ++round) {
          if (request_.progress) request_.progress(round, most);
          if (!add_best_term(false)) break;
          exchange_terms();
        }
      } while (drop_failing() && has_room());
      if (request_.scope.changes) prefer_common_causes();
      const size_t with_curves = static_cast<size_t>(request_.most + current_.rows().joints());
      while (request_.scope.wanted.empty() && current_.terms.size() < with_curves && add_best_term(true)) {
        if (current_.terms.back().term.kind == TermKind::kCurve) replace_names_by_curve();
      }
      drop_failing();
    }
    // Computes the values for the last set.
    for (size_t k = 0; k < current_.terms.size(); ++k) {
      if (current_.terms[k].term.is_linearised()) current_.linearise(k);
    }
    const VectorXd untested_share = predicted_by_curves();
    SearchResult out = outcome_of(current_, exchanges_, request_);
    out.untested_share = untested_share;
    return out;
  }

 private:
  // Curves can imitate any named cause, and so can effects that imitate many others: they are compared after
  // all others, unless the user names them.
  bool is_compared_last(const Term& t) const { return t.kind == TermKind::kCurve || (t.imitates && request_.scope.wanted.empty()); }

  // A refuted term is not compared again.
  bool is_compared_now(const Term& t) const { return !is_compared_last(t) && aside_.count(t.place) == 0; }

  // True if the error of some joint rises significantly.
  // True if a term costs a joint a good part of what it gains on all. Smaller losses come from the parameters that joints share.
  static bool makes_worse(const Gain& g) {
    for (Eigen::Index i = 0; i < g.of_joint.size(); ++i) {
      if (g.rise[i] > kSmallestDecrease && -g.of_joint[i] > std::max(kStandardErrorsWithoutTest * g.error_of_joint[i], kLossShare * g.sum)) return true;
    }
    return false;
  }

  bool passes(const Gain& g, const Term& t) const {
    const bool helps_its_joint = !t.joint || g.of_joint[t.joint->value] > 0.0;
    // A MODEL's own parameters may move at a cost. A change or a load that moves in their place saves this
    // cost, even if the error stays the same.
    const bool moves_as_model = t.kind == TermKind::kChange || t.kind == TermKind::kLoad;
    const bool matters = (g.share >= (request_.scope.changes ? kSmallestChange : kSmallestDecrease) && helps_its_joint) || (moves_as_model && g.prior > t.price + 0.5 * kStandardErrorsWithoutTest * kStandardErrorsWithoutTest);
    const double odds = current_.is_repeated() || t.is_daily ? 0.0 : kLnPosteriorOdds;
    return g.sum > t.price + odds && g.sum > g.limit && matters;
  }

  // Adds the term that lowers the score most; false if none passes the tests.
  bool add_best_term(bool curves) {
    const Round now = current_.round();
    const Subset& s = now.whole();
    const Fitted& fit = now.fit();
    const bool has_room = std::count_if(current_.terms.begin(), current_.terms.end(), [](const Chosen& c) { return c.term.kind != TermKind::kCurve; }) < request_.most;
    const auto may_enter = [&](const Term& t) {
      return !current_.is_chosen(t) && aside_.count(t.place) == 0 && is_compared_last(t) == curves && (has_room || t.kind == TermKind::kCurve);
    };
    std::vector<TermProducts> all = exchanges_.products_of_dictionary(now, may_enter);
    if (!curves) append(exchanges_.products_of_ripples(now, fit.residual), all);
    std::vector<Exchange> exchanges = exchanges_.best_terms(now, s, all, 1.0, may_enter);
    if (!curves && !far_gravities_tested_) {
      far_gravities_tested_ = true;
      append(exchanges_.far_gravities(now, fit), exchanges);
      std::sort(exchanges.begin(), exchanges.end(), [](const Exchange& a, const Exchange& b) { return a.value < b.value; });
    }
    for (Exchange& e : exchanges) {
      if (!(e.value < fit.score)) break;
      if (!passes(now.gain(e.fit, fit), e.term)) continue;
      const CurrentSet::State state = current_.snapshot();
      current_.terms.push_back(chosen_of(e));
      if (!e.term.is_linearised() || current_.linearise(current_.terms.size() - 1)) return true;
      current_.restore(state);
      aside_.insert(e.term.place);
    }
    return false;
  }

  // Friction that the file does not have is added on all joints at once. If joints came one by one, the first
  // friction would also be fitted to the others' residual, and resemble a power law.
  void begin_with_friction() {
    for (const Term& t : current_.dictionary()) {
      if (t.kind != TermKind::kEffect || !t.joint || request_.without_friction.count(t.joint->value) == 0) continue;
      if (!find_effect(t.effect.effect).traits().elementary || current_.is_chosen(t)) continue;
      if (std::abs(t.effect.axis.coefficients[t.joint->value]) < kAlongJoint * t.effect.axis.coefficients.norm()) continue;
      if (!t.effect.values.empty()) continue;
      Exchange e;
      e.term = t;
      e.columns = std::make_shared<Columns>(columns_of(t, current_.rows()));
      e.ridge = VectorXd::Zero(e.columns->count());
      current_.terms.push_back(chosen_of(e));
    }
    drop_superfluous();
  }

  // Removes the terms `gone` and appends the term of `e`; a linearised one also corrects the arm.
  void replace_terms(const std::set<size_t>& gone, const Exchange& e) {
    std::vector<Chosen> kept;
    for (size_t k = 0; k < current_.terms.size(); ++k) {
      if (gone.count(k) == 0) kept.push_back(std::move(current_.terms[k]));
    }
    current_.terms = std::move(kept);
    current_.terms.push_back(chosen_of(e));
    if (e.term.is_linearised()) current_.linearise(current_.terms.size() - 1);
  }

  // Compares each chosen term with its removal, with every other term in its place, and pairs of terms with
  // one.
  void exchange_terms() {
    for (int turn = 0; turn < kTurns && !current_.terms.empty(); ++turn) {
      if (!exchange_once()) return;
    }
  }

  // Makes the first exchange that lowers the score enough; false if there is none.
  bool exchange_once() {
    const Round now = current_.round();
    const size_t count = current_.terms.size();
    const std::vector<int> all = current_.all_but({});
    const Fitted& full = now.fit();
    const double value = full.score + current_.price_of(all);
    std::vector<TermProducts> names = exchanges_.products_of_dictionary(now, [&](const Term& t) { return is_compared_now(t); });
    append(exchanges_.products_of_ripples(now, full.residual), names);
    for (size_t k = 0; k < count; ++k) {
      if (current_.terms[k].term.is_linearised()) continue;
      const std::vector<int> rest = current_.all_but({k});
      const Subset s = now.subset(rest);
      const Fitted without = now.evaluate(s);
      if (without.score + current_.price_of(rest) <= value) {
        current_.terms.erase(current_.terms.begin() + static_cast<long>(k));
        return true;
      }
      append(exchanges_.products_of(now, {current_.terms[k].term}), names);
      const double gained = without.score - full.score;
      std::vector<Exchange> exchanges = exchanges_.best_terms(now, s, names, gained, [&](const Term& t) { return is_compared_now(t) && !current_.is_chosen(t, {k}) && current_.shares_joint(t, {k}); });
      for (Exchange& e : exchanges) {
        if (e.value + current_.price_of(rest) >= value - kExchangeGain) break;
        const Gain g = now.gain(e.fit, full);
        // A more expensive term replaces a cheaper one only by the margins that an added term needs.
        if (e.term.price > current_.terms[k].term.price + kGramRidge && g.sum < g.limit) continue;
        if (!passes(now.gain(e.fit, without), e.term)) continue;
        const bool same = same_place(e.term, current_.terms[k].term);
        if (same && e.value + current_.price_of(rest) >= value - 1.0) break;
        replace_terms({k}, e);
        return true;
      }
      names.pop_back();
    }
    for (const std::set<size_t>& some : replaceable_groups()) {
      const std::vector<int> rest = current_.all_but(some);
      const Subset s = now.subset(rest);
      const Fitted without = now.evaluate(s);
      std::vector<Exchange> exchanges = exchanges_.best_terms(now, s, names, without.score - full.score, [&](const Term& t) { return is_compared_now(t) && !current_.is_chosen(t, some) && current_.shares_joint(t, some); });
      for (Exchange& e : exchanges) {
        if (e.value + current_.price_of(rest) >= value) break;
        if (!passes(now.gain(e.fit, without), e.term)) continue;
        replace_terms(some, e);
        return true;
      }
    }
    return replace_by_whole_arm_term();
  }

  // Puts the most common cause in place of each chosen term among those that explain as much, within the error of their
  // difference. An arm's first model is fitted with whatever predicts it best.
  void prefer_common_causes() {
    for (size_t k = 0; k < current_.terms.size();) {
      const Term chosen = current_.terms[k].term;
      if (chosen.is_linearised() || chosen.kind == TermKind::kCurve) {
        ++k;
        continue;
      }
      const Round now = current_.round();
      const Fitted& full = now.fit();
      const Subset s = now.subset(current_.all_but({k}));
      const Fitted without = now.evaluate(s);
      const auto may_enter = [&](const Term& t) { return is_compared_now(t) && t.price < chosen.price - kGramRidge && !current_.is_chosen(t, {k}) && current_.shares_joint(t, {k}); };
      std::vector<Exchange> common = exchanges_.best_terms(now, s, exchanges_.products_of_dictionary(now, may_enter), without.score - full.score, may_enter);
      common.erase(std::remove_if(common.begin(), common.end(), [&](const Exchange& e) {
                     if (!std::isfinite(e.value) || !passes(now.gain(e.fit, without), e.term)) return true;
                     const Gain more = now.gain(full, e.fit);
                     return more.sum + e.term.price - chosen.price > kStandardErrorsWithoutTest * more.error;
                   }), common.end());
      const auto cheapest = std::min_element(common.begin(), common.end(), [](const Exchange& a, const Exchange& b) { return a.term.price < b.term.price; });
      if (cheapest == common.end()) ++k;
      else replace_terms({k}, *cheapest);  // the new term is the last one, and the next term has the index k
    }
  }

  // Groups of terms that one other term may replace: any two of a joint, and all of a joint.
  std::vector<std::set<size_t>> replaceable_groups() const {
    std::set<std::set<size_t>> out;
    std::map<int, std::set<size_t>> of_joint;
    for (size_t k = 0; k < current_.terms.size(); ++k) {
      if (current_.terms[k].term.is_linearised()) continue;
      if (current_.terms[k].term.joint) of_joint[current_.terms[k].term.joint->value].insert(k);
      for (size_t c = 0; c < k; ++c) {
        if (current_.terms[c].term.is_linearised()) continue;
        if (!current_.terms[k].term.joint || !current_.terms[c].term.joint || current_.terms[k].term.joint == current_.terms[c].term.joint) out.insert({c, k});
      }
    }
    for (const auto& [joint, all] : of_joint) {
      if (all.size() > 2) out.insert(all);
    }
    return {out.begin(), out.end()};
  }

  // Lets the curve that was added last replace all named terms of its joint, if these gain less than half of
  // what the curve gains alone.
  void replace_names_by_curve() {
    const size_t last = current_.terms.size() - 1;
    std::set<size_t> names;
    for (size_t k = 0; k < last; ++k) {
      if (current_.terms[k].term.kind != TermKind::kCurve && !current_.terms[k].term.is_linearised() && current_.terms[k].term.joint == current_.terms[last].term.joint) names.insert(k);
    }
    if (names.empty()) return;
    const Round now = current_.round();
    std::set<size_t> curve = {last};
    const Fitted with_names = now.evaluate(now.subset(current_.all_but(curve)));
    const Fitted with_curve = now.evaluate(now.subset(current_.all_but(names)));
    double paid = current_.terms[last].term.price;
    for (const size_t k : names) paid -= current_.terms[k].term.price;
    const Gain g = now.gain(with_curve, with_names);
    if (g.sum <= std::max(g.limit, paid)) return;
    std::set<size_t> both = names;
    both.insert(last);
    const Fitted neither = now.evaluate(now.subset(current_.all_but(both)));
    if (now.gain(with_names, neither).sum > kRivalGainShare * now.gain(with_curve, neither).sum) return;
    std::vector<Chosen> kept;
    for (size_t k = 0; k <= last; ++k) {
      if (names.count(k) == 0) kept.push_back(std::move(current_.terms[k]));
    }
    current_.terms = std::move(kept);
  }

  // Compares all terms on several joints with a single term that acts on several joints, linearised again;
  // drops terms that are then superfluous. Each such term is tried once for every number of terms.
  bool replace_by_whole_arm_term() {
    const size_t own = std::count_if(current_.terms.begin(), current_.terms.end(), [](const Chosen& c) { return c.term.joint.has_value(); });
    if (own < 2) return false;
    const CurrentSet::State state = current_.snapshot();
    const std::vector<Chosen>& before = state.terms;
    const Round now = current_.round();
    const Fitted& full = now.fit();
    std::set<size_t> local;
    for (size_t k = 0; k < before.size(); ++k) {
      if (before[k].term.joint) local.insert(k);
    }
    const Subset s = now.subset(current_.all_but(local));
    const auto may_enter = [&](const Term& t) {
      return is_compared_now(t) && !t.joint && !current_.is_chosen(t) && tried_.count(t.place + std::to_string(before.size())) == 0;
    };
    std::vector<Exchange> exchanges = exchanges_.best_terms(now, s, exchanges_.products_of_dictionary(now, may_enter), 1.0, may_enter);
    exchanges.resize(std::min(exchanges.size(), kMostWholeArm));
    for (const Exchange& e : exchanges) {
      tried_.insert(e.term.place + std::to_string(before.size()));
      if (!std::isfinite(e.value)) continue;
      current_.terms.clear();
      for (size_t k = 0; k < before.size(); ++k) {
        if (local.count(k) == 0) current_.terms.push_back(before[k]);
      }
      current_.terms.push_back(chosen_of(e));
      if (e.term.is_linearised()) current_.linearise(current_.terms.size() - 1);
      for (const size_t k : local) {
        current_.terms.push_back(before[k]);
        current_.terms.back().columns = columns_of(before[k].term, current_.rows());
      }
      drop_superfluous();
      const Round then = current_.round();
      const Fitted& after = then.fit();
      double change = 0.0;
      for (const Chosen& c : current_.terms) change += c.term.price;
      for (const Chosen& c : before) change -= c.term.price;
      if (now.gain(after, full).sum > change + kExchangeGain && !has_same_causes(before)) return true;
      current_.restore(state);
    }
    return false;
  }

  bool has_same_causes(const std::vector<Chosen>& other) const {
    std::multiset<std::string> a, b;
    for (const Chosen& c : current_.terms) a.insert(c.term.place);
    for (const Chosen& c : other) b.insert(c.term.place);
    return a == b;
  }

  // Removes terms, the one with the smallest gain first, as long as the score decreases.
  void drop_superfluous() {
    while (!current_.terms.empty()) {
      const Round now = current_.round();
      const double all = now.fit().score;
      double best = 0.0;
      std::optional<size_t> gone;
      for (size_t k = 0; k < current_.terms.size(); ++k) {
        if (current_.terms[k].term.is_linearised()) continue;
        const double loss = now.evaluate(now.subset(current_.all_but({k}))).score - all - current_.terms[k].term.price;
        if (loss < best) {
          best = loss;
          gone = k;
        }
      }
      if (!gone) return;
      current_.terms.erase(current_.terms.begin() + static_cast<long>(*gone));
    }
  }

  // True if a term's gain on the held-out recordings is too small.
  static bool is_contradicted(const Gain& on_test) {
    return on_test.of_joint.size() > 0 && on_test.sum < on_test.limit;
  }

  // Share of the held-out recordings' mean square that curves predict in addition to the requested causes.
  VectorXd predicted_by_curves() {
    if (request_.scope.wanted.empty() || current_.is_empty()) return {};
    const auto left = [&] {
      const Round now = current_.round();
      return request_.test.empty() ? now.fit().residual : current_.test_residual_of(now.fit().x, current_.all_but({}));
    };
    const CurrentSet::State state = current_.snapshot();
    const size_t names = state.terms.size();
    const MatrixXd before = left();
    while (current_.terms.size() < names + static_cast<size_t>(current_.rows().joints()) && add_best_term(true)) {}
    const MatrixXd after = left();
    VectorXd out = VectorXd::Constant(current_.rows().joints(), -1.0);
    for (size_t k = names; k < current_.terms.size(); ++k) {
      const int j = current_.terms[k].term.joint.value_or(JointIndex{0}).value;
      out[j] = std::max(0.0, 1.0 - after.col(j).squaredNorm() / std::max(before.col(j).squaredNorm(), numerics::kTiny));
    }
    current_.restore(state);
    return out;
  }

  // @param x, deviations  coefficients of the whole set.
  bool is_insignificant_load(size_t k, const VectorXd& x, const VectorXd& deviations) const {
    if (current_.terms[k].term.kind != TermKind::kLoad) return false;
    const auto [first, count] = current_.range(k);
    const double blocks = std::max(1.0, current_.folds().blocks - 1.0);
    return !is_load(x.segment(first, count), deviations.segment(first, count), student_t_quantile(numerics::kOutside, blocks));
  }

  // Drops terms that do not pass the tests next to all others, the weakest first; a term dropped twice is not
  // tried again. True if any was dropped.
  bool drop_failing() {
    bool any = false;
    while (!current_.terms.empty()) {
      const Round now = current_.round();
      const Fitted& fit = now.fit();
      const VectorXd deviations = now.covariance(now.whole(), fit, MatrixXd::Identity(fit.x.size(), fit.x.size())).diagonal().cwiseSqrt();
      std::optional<size_t> gone;
      double least = 0.0;
      bool is_refuted = false;
      for (size_t k = 0; k < current_.terms.size(); ++k) {
        const CurrentSet::LeaveOneOut w = current_.evaluate_without(k, now);
        const bool refuted = is_contradicted(w.on_test);
        const double margin = refuted ? w.on_test.sum / std::max(w.on_test.error, numerics::kNoise) - numerics::kHuge : w.gain.sum / std::max(w.gain.error, numerics::kNoise);
        if ((refuted || !passes(w.gain, current_.terms[k].term) || makes_worse(w.gain) || is_insignificant_load(k, fit.x, deviations)) && (!gone || margin < least)) {
          gone = k;
          least = margin;
          is_refuted = refuted;
        }
      }
      if (!gone) return any;
      any = true;
      if (++cleaned_[current_.terms[*gone].term.place] > 1 || is_refuted) aside_.insert(current_.terms[*gone].term.place);
      const bool moved = current_.terms[*gone].term.is_linearised();
      current_.terms.erase(current_.terms.begin() + static_cast<long>(*gone));
      if (moved) current_.move_to(current_.arm_of(current_.terms));
    }
    return any;
  }

  const SearchRequest& request_;
  CurrentSet current_;
  Exchanges exchanges_;
  std::set<std::string> aside_, tried_;
  std::map<std::string, int> cleaned_;
  bool far_gravities_tested_ = false;
};

}  // namespace

bool is_load(const VectorXd& values, const VectorXd& deviations, double quantile) {
  double moment = 0.0, deviation = 0.0;
  for (int k = 1; k < 4; ++k) {
    if (deviations[k] >= kDeterminedShare * kMassOfArm * kReach) continue;
    moment = std::hypot(moment, values[k]);
    deviation = std::hypot(deviation, deviations[k]);
  }
  return std::abs(values[0]) > quantile * deviations[0] || moment > quantile * deviation;
}

SearchResult search(const Model& arm, const SearchRequest& request) {
  return Search(arm, request).run();
}

}  // namespace veridyn::search
