#include "diagnosis/search/outcome.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <set>

#include "diagnosis/search/numbers.hpp"
#include "math/parallel.hpp"
#include "veridyn/regressor/standard_parameters.hpp"

namespace veridyn::search {
namespace {

class Outcome {
 public:
  Outcome(CurrentSet& at, Exchanges& exchanges, const SearchRequest& request) : current_(at), exchanges_(exchanges), request_(request) {}

  SearchResult compute() {
    SearchResult out;
    out.folds = current_.folds();
    out.tested_terms = compared_causes();
    out.degrees_of_freedom = std::max(1, current_.folds().blocks - 1);
    if (current_.is_empty()) {
      out.rows = current_.shared_rows();
      return out;
    }
    const Round now = current_.round();
    const Subset& s = now.whole();
    const Fitted& full = now.fit();
    const MatrixXd covariance = now.covariance(s, full, values_by_coefficients(full.x.size()));
    const std::vector<TermProducts> names = exchanges_.products_of_dictionary(now, [](const Term& t) { return t.kind != TermKind::kCurve; });
    const auto relative = [&](const Fitted& f) {
      VectorXd e(current_.rows().joints());
      for (Eigen::Index i = 0; i < e.size(); ++i) {
        double error = 0.0, torque = 0.0;
        for (Eigen::Index r = 0; r < current_.rows().rows(); ++r) {
          if (current_.folds().of_row[r] < 0 || current_.rows().used(r, i) == 0.0) continue;
          error += f.residual(r, i) * f.residual(r, i);
          torque += current_.rows().measured(r, i) * current_.rows().measured(r, i);
        }
        e[i] = torque > 0.0 ? std::sqrt(error / torque) : 0.0;
      }
      return e;
    };
    for (size_t k = 0; k < current_.terms.size(); ++k) {
      const auto [first, count] = current_.range(k);
      std::vector<Chosen::RivalTerm> rivals;
      const Term term = current_.terms[k].term;
      const CurrentSet::LeaveOneOut w = current_.evaluate_without(k, now, [&](const Round& then, const Subset& all, const Fitted& fit, double gained) {
        rivals = rivals_of_linearised(then, all, fit, gained, term);
      });
      Chosen& c = current_.terms[k];
      c.rivals = std::move(rivals);
      c.gain = w.gain.sum;
      c.error = w.gain.error;
      c.of_joint = w.gain.of_joint;
      c.folds_before = relative(w.fit);
      c.folds_after = relative(w.with);
      c.values = full.x.segment(first, count);
      for (size_t p = 0; p < c.offset.size() && !c.gravity; ++p)
        c.values[static_cast<Eigen::Index>(p)] = is_factor(c.term) ? (1.0 + c.offset[p]) * (1.0 + c.values[static_cast<Eigen::Index>(p)]) - 1.0
                                                                   : c.values[static_cast<Eigen::Index>(p)] + c.offset[p];
      c.covariance = covariance.block(first, first, count, count);
      c.deviations = c.covariance.diagonal().cwiseSqrt();
      set_shape_deviations(now, k, c);
      if (!c.term.is_linearised()) find_rivals(now, names, full, k, c);
    }
    find_rejected(now, s, full, names, out);
    out.rows = current_.shared_rows();
    out.residual = full.residual;
    out.scale = now.scale();
    out.weights = MatrixXd::Ones(full.residual.rows(), full.residual.cols());
    for (Eigen::Index i = 0; i < out.weights.cols(); ++i)
      out.weights.col(i) = (kFreedom + 1.0) / (kFreedom + (full.residual.col(i).array() / out.scale[i]).square());
    out.values = current_.values_of(full);
    out.fitted = current_.rows().residual;
    for (int i = 0; i < current_.rows().joints(); ++i) out.fitted.col(i) -= current_.base().X[i] * full.x.head(current_.base().T.cols());
    for (Chosen& c : current_.terms) {
      VectorXd z = c.values;
      if (c.term.is_linearised()) z.setZero();
      for (size_t at = 0; at < c.columns.joints.size(); ++at) out.fitted.col(c.columns.joints[at]) -= c.columns.of[at] * z;
    }
    std::stable_sort(current_.terms.begin(), current_.terms.end(), [](const Chosen& a, const Chosen& b) {
      const bool is_curve = a.term.kind == TermKind::kCurve;
      return is_curve != (b.term.kind == TermKind::kCurve) ? !is_curve : a.gain > b.gain;
    });
    collect_daily_changes(full, out);
    set_test_errors(out);
    out.chosen = std::move(current_.terms);
    return out;
  }

 private:
  // A level that differs from day to day may also move with the MODEL's own parameters: its change is the sum of both.
  // Calls visit(term, index of the value, index of the parameter) for each of its values.
  template <typename Visit>
  void for_daily_levels(const Visit& visit) {
    const std::vector<StandardParameter> parameters = standard_parameters(current_.rows().arm());
    for (size_t k = 0; k < current_.terms.size(); ++k) {
      const Term& t = current_.terms[k].term;
      for (size_t p = 0; t.is_daily && p < parameters.size(); ++p) {
        if (parameters[p].effect && static_cast<size_t>(*parameters[p].effect) == t.candidate.own->value)
          visit(k, parameters[p].component, static_cast<Eigen::Index>(p));
      }
    }
  }

  // Combinations of all coefficients that are the values of the terms.
  MatrixXd values_by_coefficients(Eigen::Index count) {
    MatrixXd out = MatrixXd::Identity(count, count);
    const MatrixXd& T = current_.base().T;
    for_daily_levels([&](size_t k, int value, Eigen::Index p) { out.row(current_.range(k).first + value).head(T.cols()) = T.row(p); });
    return out;
  }

  // Moves the whole change of a daily level to its term.
  void collect_daily_changes(const Fitted& full, SearchResult& out) {
    const MatrixXd& T = current_.base().T;
    for_daily_levels([&](size_t k, int value, Eigen::Index p) {
      const double shift = T.row(p).dot(full.x.head(T.cols()));
      Chosen& c = current_.terms[k];
      c.values[value] += shift;
      for (const Level& level : c.term.nonnegative) {
        if (level.column == value) c.values[value] = std::max(c.values[value], -level.own);
      }
      out.values[p] -= shift;
    });
  }

  // Number of compared causes; each place counts once.
  int compared_causes() const {
    std::set<std::string> places;
    for (const Term& t : current_.dictionary()) {
      const bool is_selected = t.kind != TermKind::kCurve || request_.scope.wanted.empty();
      if (is_selected && t.place.find(" other") == std::string::npos) places.insert(t.place);
    }
    return static_cast<int>(places.size());
  }

  // Errors on held-out recordings with the first terms of the set, fitted to all training rows. For a MODEL
  // the base keeps the values of the whole set: without a term its own parameters would move to replace it.
  void set_test_errors(SearchResult& out) {
    if (request_.test.empty()) return;
    out.test_error.resize(static_cast<Eigen::Index>(current_.terms.size()) + 1, current_.rows().joints());
    std::optional<Round> then;
    VectorXd x;
    for (size_t m = current_.terms.size() + 1; m-- > 0;) {
      const std::vector<Chosen> first(current_.terms.begin(), current_.terms.begin() + static_cast<long>(m));
      const bool again = m == current_.terms.size() || current_.terms[m].term.is_linearised();
      if (again && m < current_.terms.size() && !current_.move_to(current_.arm_of(first))) {
        out.test_error.row(static_cast<Eigen::Index>(m)) = out.test_error.row(static_cast<Eigen::Index>(m) + 1);
        continue;
      }
      if (again) then.emplace(current_.round());
      std::vector<int> some(m);
      std::iota(some.begin(), some.end(), 0);
      if (!request_.scope.changes || m == current_.terms.size()) x = then->evaluate(then->subset(some)).x;
      const MatrixXd residual = current_.test_residual_of(x, some);
      out.test_error.row(static_cast<Eigen::Index>(m)) = residual.colwise().norm() / std::sqrt(static_cast<double>(std::max<Eigen::Index>(1, residual.rows())));
      if (m < current_.terms.size()) continue;
      out.test = current_.test_rows();
      out.test_residual = residual;
    }
  }

  // Standard deviations of the shapes, by the curvature of the score.
  void set_shape_deviations(const Round& now, size_t k, Chosen& c) {
    const Subset rest = now.subset(current_.all_but({k}));
    for (const TermShape& shape : c.term.shapes) {
      const double value = c.term.effect.values.at(shape.name);
      double deviation = std::numeric_limits<double>::quiet_NaN();
      const double centre = exchanges_.exchange_with(now, rest, c.term).value;
      for (double step = kFirstProfile; step < 2.0; step *= 2.0) {
        const auto at = [&](double side) {
          Term t = c.term;
          t.effect.values[shape.name] = shape.logarithmic ? value * std::exp(side * step) : value + side * step * shape.step;
          return exchanges_.exchange_with(now, rest, t).value;
        };
        const double rise = 0.5 * (at(1.0) + at(-1.0)) - centre;
        if (rise < 0.5) continue;
        // The score S rises by 1/2 at one standard deviation.
        deviation = step * std::sqrt(0.5 / rise) * (shape.logarithmic ? value : shape.step);
        break;
      }
      c.shape_deviations.push_back(deviation);
    }
  }

  // Rivals of a linearised term: terms with nearly its gain, to first order, at the arm without it.
  std::vector<Chosen::RivalTerm> rivals_of_linearised(const Round& then, const Subset& all, const Fitted& fit, double gained, const Term& term) {
    std::vector<Chosen::RivalTerm> out;
    const auto is_rival = [&](const Term& t) { return !same_place(t, term) && t.kind != TermKind::kCurve; };
    for (const Exchange& e : exchanges_.best_terms(then, all, exchanges_.products_of_dictionary(then, is_rival), kRivalGainShare * gained, is_rival)) {
      const Gain g = then.gain(e.fit, fit);
      if (!std::isfinite(e.value) || gained - g.sum + e.term.price - term.price > 2.0 * g.error) continue;
      out.push_back({e.term, gained - g.sum, g.sum});
    }
    out.resize(std::min(out.size(), kMostRivals));
    return out;
  }

  // Adds to c, the k-th term, the terms that gain nearly as much in its place.
  void find_rivals(const Round& now, const std::vector<TermProducts>& names, const Fitted& full, size_t k, Chosen& c) {
    const std::vector<int> rest = current_.all_but({k});
    const Subset s = now.subset(rest);
    const Fitted without = now.evaluate(s);
    for (Exchange& e : exchanges_.best_terms(now, s, names, without.score - full.score, [&](const Term& t) {
           return !current_.is_chosen(t) && t.kind != TermKind::kCurve && current_.shares_joint(t, {k});
         })) {
      if (!std::isfinite(e.value)) break;
      const Gain g = now.gain(full, e.fit);
      if (g.sum + e.term.price - c.term.price < 2.0 * g.error && without.score - e.fit.score > 0.0)
        c.rivals.push_back({e.term, g.sum, without.score - e.fit.score});
    }
    c.rivals.resize(std::min(c.rivals.size(), kMostRivals));
  }

  // Adds the best term of each cause that is not in the set.
  void find_rejected(const Round& now, const Subset& s, const Fitted& full, const std::vector<TermProducts>& names, SearchResult& out) {
    std::map<std::string, Rejected> best;
    for (const TermProducts& one : names) {
      const Term& t = one.term;
      if (current_.is_chosen(t)) continue;
      const double gain = now.training_gain(s, one.cross);
      const Rejected rejected{t, gain, 0.0, false, gain < 0.0};
      const auto at = best.find(t.place);
      if (at == best.end() || at->second.gain < gain) best[t.place] = rejected;
    }
    std::vector<Rejected> all;
    for (auto& [place, one] : best) all.push_back(one);
    std::stable_sort(all.begin(), all.end(), [](const Rejected& a, const Rejected& b) { return a.gain > b.gain; });
    std::vector<Rejected> shown(all.begin(), all.begin() + static_cast<long>(std::min(all.size(), kMostRejected)));
    parallel_for(static_cast<int>(shown.size()), request_.threads, [&](int k) {
      if (shown[k].collinear) return;
      const Exchange e = exchanges_.exchange_with(now, s, shown[k].term);
      const Gain g = now.gain(e.fit, full);
      shown[k].impossible = !std::isfinite(e.value);
      shown[k].gain = g.sum;
      shown[k].error = g.error;
    });
    for (size_t k = shown.size(); k < all.size(); ++k) {
      if (all[k].collinear) shown.push_back(all[k]);
    }
    out.rejected = std::move(shown);
  }

  CurrentSet& current_;
  Exchanges& exchanges_;
  const SearchRequest& request_;
};

}  // namespace

SearchResult outcome_of(CurrentSet& at, Exchanges& exchanges, const SearchRequest& request) {
  return Outcome(at, exchanges, request).compute();
}

}  // namespace veridyn::search
