#include "diagnosis/search/search.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <set>

#include "diagnosis/numerics.hpp"
#include "diagnosis/search/numbers.hpp"
#include "diagnosis/search/options.hpp"
#include "diagnosis/search/outcome.hpp"
#include "diagnosis/search/present.hpp"
#include "math/student_t.hpp"

namespace veridyn::search {
namespace {

Chosen chosen_of(const Option& o) {
  Chosen c;
  c.term = o.term;
  c.columns = *o.columns;
  c.ridge = o.ridge;
  c.gravity = o.gravity;
  if (c.term.is_linearised()) c.offset.assign(static_cast<size_t>(c.columns.count()), 0.0);
  return c;
}

template <typename T>
void append(std::vector<T> more, std::vector<T>& to) {
  to.insert(to.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

class Search {
 public:
  Search(const Model& arm, const SearchRequest& request) : request_(request), at_(arm, request), options_(at_, request) {}

  SearchResult run() {
    if (!at_.is_empty()) {
      begin_with_friction();
      // A curve can imitate any named cause on its joint: named terms come first, then curves next to them,
      // or in place of all named terms of a joint.
      int round = 0;
      const int most = kRounds + request_.most;
      const auto has_room = [&] { return static_cast<int>(at_.terms.size()) < request_.most && round < most; };
      do {
        for (; has_room(); ++round) {
          if (request_.progress) request_.progress(round, most);
          if (!add(false)) break;
          exchange();
        }
      } while (drop_failing() && has_room());
      if (request_.scope.changes) prefer_common_causes();
      const size_t with_curves = static_cast<size_t>(request_.most + at_.rows().joints());
      while (request_.scope.wanted.empty() && at_.terms.size() < with_curves && add(true)) {
        if (at_.terms.back().term.kind == TermKind::kCurve) replace_names_by_curve();
      }
      drop_failing();
    }
    // Computes the values for the last set.
    for (size_t k = 0; k < at_.terms.size(); ++k) {
      if (at_.terms[k].term.is_linearised()) at_.linearise(k);
    }
    const VectorXd unasked = predicted_by_curves();
    SearchResult out = outcome_of(at_, options_, request_);
    out.unasked = unasked;
    return out;
  }

 private:
  // Curves can imitate any named cause, and so can effects that imitate many others: they are compared after
  // all others, unless the user names them.
  bool is_compared_last(const Term& t) const { return t.kind == TermKind::kCurve || (t.imitates && request_.scope.wanted.empty()); }

  // A refuted term is not compared again.
  bool is_name(const Term& t) const { return !is_compared_last(t) && aside_.count(t.place) == 0; }

  static bool makes_worse(const Gain& g) {
    for (Eigen::Index i = 0; i < g.of_joint.size(); ++i) {
      if (g.rise[i] > kSmallest && g.of_joint[i] < -kErrors * g.error_of_joint[i]) return true;
    }
    return false;
  }

  bool passes(const Gain& g, const Term& t) const {
    const bool helps_its_joint = !t.joint || g.of_joint[t.joint->value] > 0.0;
    // A MODEL's own parameters may move at a cost. A change or a load that moves in their place saves this
    // cost, even if the error stays the same.
    const bool moves_as_model = t.kind == TermKind::kChange || t.kind == TermKind::kLoad;
    const bool matters = (g.share >= kSmallest && helps_its_joint) || (moves_as_model && g.prior > t.price + 0.5 * kErrors * kErrors);
    const double odds = at_.is_repeated() ? 0.0 : kOdds;
    return g.sum > t.price + odds && g.sum > g.limit && matters;
  }

  // Adds the term that lowers the score most; false if none passes the tests.
  bool add(bool curves) {
    const Round now = at_.round();
    const Subset& s = now.whole();
    const Fitted& fit = now.fit();
    const bool has_room = std::count_if(at_.terms.begin(), at_.terms.end(), [](const Chosen& c) { return c.term.kind != TermKind::kCurve; }) < request_.most;
    const auto may_enter = [&](const Term& t) {
      return !at_.is_chosen(t) && aside_.count(t.place) == 0 && is_compared_last(t) == curves && (has_room || t.kind == TermKind::kCurve);
    };
    std::vector<Beside> all = options_.dictionary(now, may_enter);
    if (!curves) append(options_.ripples(now, fit.residual), all);
    std::vector<Option> options = options_.best_terms(now, s, all, 1.0, may_enter);
    if (!curves && !far_asked_) {
      far_asked_ = true;
      append(options_.far_gravities(now, fit), options);
      std::sort(options.begin(), options.end(), [](const Option& a, const Option& b) { return a.value < b.value; });
    }
    for (Option& o : options) {
      if (!(o.value < fit.score)) break;
      if (!passes(now.gain(o.fit, fit), o.term)) continue;
      const Present::State state = at_.kept();
      at_.terms.push_back(chosen_of(o));
      if (!o.term.is_linearised() || at_.linearise(at_.terms.size() - 1)) return true;
      at_.restore(state);
      aside_.insert(o.term.place);
    }
    return false;
  }

  // Friction that the file does not have is added on all joints at once. If joints came one by one, the first
  // friction would also be fitted to the others' residual, and resemble a power law.
  void begin_with_friction() {
    for (const Term& t : at_.dictionary()) {
      if (t.kind != TermKind::kEffect || !t.joint || request_.without_friction.count(t.joint->value) == 0) continue;
      if (!find_effect(t.effect.effect).traits().elementary || at_.is_chosen(t)) continue;
      if (std::abs(t.effect.axis.coefficients[t.joint->value]) < kAlongJoint * t.effect.axis.coefficients.norm()) continue;
      if (!t.effect.values.empty()) continue;
      Option o;
      o.term = t;
      o.columns = std::make_shared<Columns>(columns_of(t, at_.rows()));
      o.ridge = VectorXd::Zero(o.columns->count());
      at_.terms.push_back(chosen_of(o));
    }
    drop_superfluous();
  }

  void replace(const std::set<size_t>& gone, const Option& o) {
    std::vector<Chosen> kept;
    for (size_t k = 0; k < at_.terms.size(); ++k) {
      if (gone.count(k) == 0) kept.push_back(std::move(at_.terms[k]));
    }
    at_.terms = std::move(kept);
    at_.terms.push_back(chosen_of(o));
    if (o.term.is_linearised()) at_.linearise(at_.terms.size() - 1);
  }

  // Compares each chosen term with its removal, with every other term in its place, and pairs of terms with
  // one.
  void exchange() {
    for (int turn = 0; turn < kTurns && !at_.terms.empty(); ++turn) {
      if (!exchange_once()) return;
    }
  }

  bool exchange_once() {
    const Round now = at_.round();
    const size_t count = at_.terms.size();
    const std::vector<int> all = at_.all_but({});
    const Fitted& full = now.fit();
    const double value = full.score + at_.price_of(all);
    std::vector<Beside> names = options_.dictionary(now, [&](const Term& t) { return is_name(t); });
    append(options_.ripples(now, full.residual), names);
    for (size_t k = 0; k < count; ++k) {
      if (at_.terms[k].term.is_linearised()) continue;
      const std::vector<int> rest = at_.all_but({k});
      const Subset s = now.subset(rest);
      const Fitted without = now.evaluate(s);
      if (without.score + at_.price_of(rest) <= value) {
        at_.terms.erase(at_.terms.begin() + static_cast<long>(k));
        return true;
      }
      append(options_.beside(now, {at_.terms[k].term}), names);
      const double gained = without.score - full.score;
      std::vector<Option> options = options_.best_terms(now, s, names, gained, [&](const Term& t) { return is_name(t) && !at_.is_chosen(t, {k}) && at_.shares_joint(t, {k}); });
      for (Option& o : options) {
        if (o.value + at_.price_of(rest) >= value - kBetter) break;
        const Gain g = now.gain(o.fit, full);
        // A more expensive term replaces a cheaper one only by the margins that an added term needs.
        if (o.term.price > at_.terms[k].term.price + kGramRidge && g.sum < g.limit) continue;
        if (!passes(now.gain(o.fit, without), o.term)) continue;
        const bool same = same_place(o.term, at_.terms[k].term);
        if (same && o.value + at_.price_of(rest) >= value - 1.0) break;
        replace({k}, o);
        return true;
      }
      names.pop_back();
    }
    for (const std::set<size_t>& some : groups()) {
      const std::vector<int> rest = at_.all_but(some);
      const Subset s = now.subset(rest);
      const Fitted without = now.evaluate(s);
      std::vector<Option> options = options_.best_terms(now, s, names, without.score - full.score, [&](const Term& t) { return is_name(t) && !at_.is_chosen(t, some) && at_.shares_joint(t, some); });
      for (Option& o : options) {
        if (o.value + at_.price_of(rest) >= value) break;
        if (!passes(now.gain(o.fit, without), o.term)) continue;
        replace(some, o);
        return true;
      }
    }
    return whole_arm();
  }

  // Puts the most common cause in place of each chosen term among those that explain as much, within the error of their
  // difference. An arm's first model is fitted with whatever predicts it best.
  void prefer_common_causes() {
    for (size_t k = 0; k < at_.terms.size();) {
      const Term chosen = at_.terms[k].term;
      if (chosen.is_linearised() || chosen.kind == TermKind::kCurve) {
        ++k;
        continue;
      }
      const Round now = at_.round();
      const Fitted& full = now.fit();
      const Subset s = now.subset(at_.all_but({k}));
      const Fitted without = now.evaluate(s);
      const auto may_enter = [&](const Term& t) { return is_name(t) && t.price < chosen.price - kGramRidge && !at_.is_chosen(t, {k}) && at_.shares_joint(t, {k}); };
      std::vector<Option> common = options_.best_terms(now, s, options_.dictionary(now, may_enter), without.score - full.score, may_enter);
      common.erase(std::remove_if(common.begin(), common.end(), [&](const Option& o) {
                     if (!std::isfinite(o.value) || !passes(now.gain(o.fit, without), o.term)) return true;
                     const Gain more = now.gain(full, o.fit);
                     return more.sum + o.term.price - chosen.price > kErrors * more.error;
                   }), common.end());
      const auto cheapest = std::min_element(common.begin(), common.end(), [](const Option& a, const Option& b) { return a.term.price < b.term.price; });
      if (cheapest == common.end()) ++k;
      else replace({k}, *cheapest);  // the new term stands last, the next one in its place
    }
  }

  // Groups of terms that one other term may replace: any two of a joint, and all of a joint.
  std::vector<std::set<size_t>> groups() const {
    std::set<std::set<size_t>> out;
    std::map<int, std::set<size_t>> of_joint;
    for (size_t k = 0; k < at_.terms.size(); ++k) {
      if (at_.terms[k].term.is_linearised()) continue;
      if (at_.terms[k].term.joint) of_joint[at_.terms[k].term.joint->value].insert(k);
      for (size_t c = 0; c < k; ++c) {
        if (at_.terms[c].term.is_linearised()) continue;
        if (!at_.terms[k].term.joint || !at_.terms[c].term.joint || at_.terms[k].term.joint == at_.terms[c].term.joint) out.insert({c, k});
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
    const size_t last = at_.terms.size() - 1;
    std::set<size_t> names;
    for (size_t k = 0; k < last; ++k) {
      if (at_.terms[k].term.kind != TermKind::kCurve && !at_.terms[k].term.is_linearised() && at_.terms[k].term.joint == at_.terms[last].term.joint) names.insert(k);
    }
    if (names.empty()) return;
    const Round now = at_.round();
    std::set<size_t> curve = {last};
    const Fitted with_names = now.evaluate(now.subset(at_.all_but(curve)));
    const Fitted with_curve = now.evaluate(now.subset(at_.all_but(names)));
    double paid = at_.terms[last].term.price;
    for (const size_t k : names) paid -= at_.terms[k].term.price;
    const Gain g = now.gain(with_curve, with_names);
    if (g.sum <= std::max(g.limit, paid)) return;
    std::set<size_t> both = names;
    both.insert(last);
    const Fitted neither = now.evaluate(now.subset(at_.all_but(both)));
    if (now.gain(with_names, neither).sum > kHalf * now.gain(with_curve, neither).sum) return;
    std::vector<Chosen> kept;
    for (size_t k = 0; k <= last; ++k) {
      if (names.count(k) == 0) kept.push_back(std::move(at_.terms[k]));
    }
    at_.terms = std::move(kept);
  }

  // Compares all terms on several joints with a single term that acts on several joints, linearised again;
  // drops terms that are then superfluous. Each such term is tried once for every number of terms.
  bool whole_arm() {
    const size_t own = std::count_if(at_.terms.begin(), at_.terms.end(), [](const Chosen& c) { return c.term.joint.has_value(); });
    if (own < 2) return false;
    const Present::State state = at_.kept();
    const std::vector<Chosen>& before = state.terms;
    const Round now = at_.round();
    const Fitted& full = now.fit();
    std::set<size_t> local;
    for (size_t k = 0; k < before.size(); ++k) {
      if (before[k].term.joint) local.insert(k);
    }
    const Subset s = now.subset(at_.all_but(local));
    const auto may_enter = [&](const Term& t) {
      return is_name(t) && !t.joint && !at_.is_chosen(t) && tried_.count(t.place + std::to_string(before.size())) == 0;
    };
    std::vector<Option> options = options_.best_terms(now, s, options_.dictionary(now, may_enter), 1.0, may_enter);
    options.resize(std::min(options.size(), kMostWholeArm));
    for (const Option& o : options) {
      tried_.insert(o.term.place + std::to_string(before.size()));
      if (!std::isfinite(o.value)) continue;
      at_.terms.clear();
      for (size_t k = 0; k < before.size(); ++k) {
        if (local.count(k) == 0) at_.terms.push_back(before[k]);
      }
      at_.terms.push_back(chosen_of(o));
      if (o.term.is_linearised()) at_.linearise(at_.terms.size() - 1);
      for (const size_t k : local) {
        at_.terms.push_back(before[k]);
        at_.terms.back().columns = columns_of(before[k].term, at_.rows());
      }
      drop_superfluous();
      const Round then = at_.round();
      const Fitted& after = then.fit();
      double change = 0.0;
      for (const Chosen& c : at_.terms) change += c.term.price;
      for (const Chosen& c : before) change -= c.term.price;
      if (now.gain(after, full).sum > change + kBetter && !same_set(before)) return true;
      at_.restore(state);
    }
    return false;
  }

  bool same_set(const std::vector<Chosen>& other) const {
    std::multiset<std::string> a, b;
    for (const Chosen& c : at_.terms) a.insert(c.term.place);
    for (const Chosen& c : other) b.insert(c.term.place);
    return a == b;
  }

  // Removes terms, the one with the smallest gain first, as long as the score decreases.
  void drop_superfluous() {
    while (!at_.terms.empty()) {
      const Round now = at_.round();
      const double all = now.fit().score;
      double best = 0.0;
      std::optional<size_t> gone;
      for (size_t k = 0; k < at_.terms.size(); ++k) {
        if (at_.terms[k].term.is_linearised()) continue;
        const double loss = now.evaluate(now.subset(at_.all_but({k}))).score - all - at_.terms[k].term.price;
        if (loss < best) {
          best = loss;
          gone = k;
        }
      }
      if (!gone) return;
      at_.terms.erase(at_.terms.begin() + static_cast<long>(*gone));
    }
  }

  // True if held-out recordings do not confirm a term's gain.
  static bool is_contradicted(const Gain& on_test) {
    return on_test.of_joint.size() > 0 && on_test.sum < on_test.limit;
  }

  // Share of the held-out recordings' mean square that curves predict in addition to the requested causes.
  VectorXd predicted_by_curves() {
    if (request_.scope.wanted.empty() || at_.is_empty()) return {};
    const auto left = [&] {
      const Round now = at_.round();
      return request_.test.empty() ? now.fit().residual : at_.test_residual_of(now.fit().x, at_.all_but({}));
    };
    const Present::State state = at_.kept();
    const size_t names = state.terms.size();
    const MatrixXd before = left();
    while (at_.terms.size() < names + static_cast<size_t>(at_.rows().joints()) && add(true)) {}
    const MatrixXd after = left();
    VectorXd out = VectorXd::Constant(at_.rows().joints(), -1.0);
    for (size_t k = names; k < at_.terms.size(); ++k) {
      const int j = at_.terms[k].term.joint.value_or(JointIndex{0}).value;
      out[j] = std::max(0.0, 1.0 - after.col(j).squaredNorm() / std::max(before.col(j).squaredNorm(), numerics::kTiny));
    }
    at_.restore(state);
    return out;
  }

  bool is_no_load(size_t k, const VectorXd& x, const VectorXd& deviations) const {
    if (at_.terms[k].term.kind != TermKind::kLoad) return false;
    const auto [first, count] = at_.range(k);
    const double blocks = std::max(1.0, at_.folds().blocks - 1.0);
    return !is_load(x.segment(first, count), deviations.segment(first, count), student_t_quantile(numerics::kOutside, blocks));
  }

  // Drops terms that do not pass the tests next to all others, the weakest first; a term dropped twice is not
  // tried again. True if any was dropped.
  bool drop_failing() {
    bool any = false;
    while (!at_.terms.empty()) {
      const Round now = at_.round();
      const Fitted& fit = now.fit();
      const VectorXd deviations = now.covariance(now.whole(), fit).diagonal().cwiseSqrt();
      std::optional<size_t> gone;
      double least = 0.0;
      bool is_refuted = false;
      for (size_t k = 0; k < at_.terms.size(); ++k) {
        const Present::Without w = at_.without(k, now);
        const bool refuted = is_contradicted(w.on_test);
        const double margin = refuted ? w.on_test.sum / std::max(w.on_test.error, numerics::kNoise) - numerics::kHuge : w.gain.sum / std::max(w.gain.error, numerics::kNoise);
        if ((refuted || !passes(w.gain, at_.terms[k].term) || makes_worse(w.gain) || is_no_load(k, fit.x, deviations)) && (!gone || margin < least)) {
          gone = k;
          least = margin;
          is_refuted = refuted;
        }
      }
      if (!gone) return any;
      any = true;
      if (++cleaned_[at_.terms[*gone].term.place] > 1 || is_refuted) aside_.insert(at_.terms[*gone].term.place);
      const bool moved = at_.terms[*gone].term.is_linearised();
      at_.terms.erase(at_.terms.begin() + static_cast<long>(*gone));
      if (moved) at_.move_to(at_.arm_of(at_.terms));
    }
    return any;
  }

  const SearchRequest& request_;
  Present at_;
  Options options_;
  std::set<std::string> aside_, tried_;
  std::map<std::string, int> cleaned_;
  bool far_asked_ = false;
};

}  // namespace

bool is_load(const VectorXd& values, const VectorXd& deviations, double quantile) {
  double moment = 0.0, deviation = 0.0;
  for (int k = 1; k < 4; ++k) {
    if (deviations[k] >= kSeen * kMassOfArm * kReach) continue;
    moment = std::hypot(moment, values[k]);
    deviation = std::hypot(deviation, deviations[k]);
  }
  return std::abs(values[0]) > quantile * deviations[0] || moment > quantile * deviation;
}

SearchResult search(const Model& arm, const SearchRequest& request) {
  return Search(arm, request).run();
}

}  // namespace veridyn::search
