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

namespace veridyn::search {
namespace {

class Outcome {
 public:
  Outcome(Present& at, Options& options, const SearchRequest& request) : at_(at), options_(options), request_(request) {}

  SearchResult write() {
    SearchResult out;
    out.folds = at_.folds();
    out.asked = compared_causes();
    out.degrees_of_freedom = std::max(1, at_.folds().blocks - 1);
    if (at_.is_empty()) {
      out.rows = at_.shared_rows();
      return out;
    }
    const Round now = at_.round();
    const Subset& s = now.whole();
    const Fitted& full = now.fit();
    const MatrixXd covariance = now.covariance(s, full);
    const std::vector<Beside> names = options_.dictionary(now, [](const Term& t) { return t.kind != TermKind::kCurve; });
    const auto relative = [&](const Fitted& f) {
      VectorXd e(at_.rows().joints());
      for (Eigen::Index i = 0; i < e.size(); ++i) {
        double error = 0.0, torque = 0.0;
        for (Eigen::Index r = 0; r < at_.rows().rows(); ++r) {
          if (at_.folds().of_row[r] < 0 || at_.rows().used(r, i) == 0.0) continue;
          error += f.residual(r, i) * f.residual(r, i);
          torque += at_.rows().measured(r, i) * at_.rows().measured(r, i);
        }
        e[i] = torque > 0.0 ? std::sqrt(error / torque) : 0.0;
      }
      return e;
    };
    for (size_t k = 0; k < at_.terms.size(); ++k) {
      const auto [first, count] = at_.range(k);
      std::vector<Chosen::RivalTerm> rivals;
      const Term term = at_.terms[k].term;
      const Present::Without w = at_.without(k, now, [&](const Round& then, const Subset& all, const Fitted& fit, double gained) {
        rivals = rivals_of_linearised(then, all, fit, gained, term);
      });
      Chosen& c = at_.terms[k];
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
    find_refused(now, s, full, names, out);
    out.rows = at_.shared_rows();
    out.residual = full.residual;
    out.scale = now.scale();
    out.weights = MatrixXd::Ones(full.residual.rows(), full.residual.cols());
    for (Eigen::Index i = 0; i < out.weights.cols(); ++i)
      out.weights.col(i) = (kFreedom + 1.0) / (kFreedom + (full.residual.col(i).array() / out.scale[i]).square());
    out.values = at_.values_of(full);
    out.fitted = at_.rows().residual;
    for (int i = 0; i < at_.rows().joints(); ++i) out.fitted.col(i) -= at_.base().X[i] * full.x.head(at_.base().T.cols());
    for (Chosen& c : at_.terms) {
      VectorXd z = c.values;
      if (c.term.is_linearised()) z.setZero();
      for (size_t at = 0; at < c.columns.joints.size(); ++at) out.fitted.col(c.columns.joints[at]) -= c.columns.of[at] * z;
    }
    std::stable_sort(at_.terms.begin(), at_.terms.end(), [](const Chosen& a, const Chosen& b) {
      const bool is_curve = a.term.kind == TermKind::kCurve;
      return is_curve != (b.term.kind == TermKind::kCurve) ? !is_curve : a.gain > b.gain;
    });
    set_test_errors(out);
    out.chosen = std::move(at_.terms);
    return out;
  }

 private:
  // Number of compared causes; each place counts once.
  int compared_causes() const {
    std::set<std::string> places;
    for (const Term& t : at_.dictionary()) {
      const bool is_asked = t.kind != TermKind::kCurve || request_.scope.wanted.empty();
      if (is_asked && t.place.find(" other") == std::string::npos) places.insert(t.place);
    }
    return static_cast<int>(places.size());
  }

  // Errors on held-out recordings with the first terms of the set, fitted to all training rows. For a MODEL
  // the base keeps the values of the whole set: without a term its own parameters would move to replace it.
  void set_test_errors(SearchResult& out) {
    if (request_.test.empty()) return;
    out.test_error.resize(static_cast<Eigen::Index>(at_.terms.size()) + 1, at_.rows().joints());
    std::optional<Round> then;
    VectorXd x;
    for (size_t m = at_.terms.size() + 1; m-- > 0;) {
      const std::vector<Chosen> first(at_.terms.begin(), at_.terms.begin() + static_cast<long>(m));
      const bool again = m == at_.terms.size() || at_.terms[m].term.is_linearised();
      if (again && m < at_.terms.size() && !at_.move_to(at_.arm_of(first))) {
        out.test_error.row(static_cast<Eigen::Index>(m)) = out.test_error.row(static_cast<Eigen::Index>(m) + 1);
        continue;
      }
      if (again) then.emplace(at_.round());
      std::vector<int> some(m);
      std::iota(some.begin(), some.end(), 0);
      if (!request_.scope.changes || m == at_.terms.size()) x = then->evaluate(then->subset(some)).x;
      const MatrixXd residual = at_.test_residual_of(x, some);
      out.test_error.row(static_cast<Eigen::Index>(m)) = residual.colwise().norm() / std::sqrt(static_cast<double>(std::max<Eigen::Index>(1, residual.rows())));
      if (m < at_.terms.size()) continue;
      out.test = at_.test_rows();
      out.test_residual = residual;
    }
  }

  // Standard deviations of the shapes, by the curvature of the score.
  void set_shape_deviations(const Round& now, size_t k, Chosen& c) {
    const Subset rest = now.subset(at_.all_but({k}));
    for (const TermShape& shape : c.term.shapes) {
      const double value = c.term.effect.values.at(shape.name);
      double deviation = std::numeric_limits<double>::quiet_NaN();
      const double centre = options_.option(now, rest, c.term).value;
      for (double step = kFirstProfile; step < 2.0; step *= 2.0) {
        const auto at = [&](double side) {
          Term t = c.term;
          t.effect.values[shape.name] = shape.logarithmic ? value * std::exp(side * step) : value + side * step * shape.step;
          return options_.option(now, rest, t).value;
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
    for (const Option& o : options_.best_terms(then, all, options_.dictionary(then, is_rival), kHalf * gained, is_rival)) {
      const Gain g = then.gain(o.fit, fit);
      if (!std::isfinite(o.value) || gained - g.sum + o.term.price - term.price > 2.0 * g.error) continue;
      out.push_back({o.term, gained - g.sum, g.sum});
    }
    out.resize(std::min(out.size(), kMostRivals));
    return out;
  }

  void find_rivals(const Round& now, const std::vector<Beside>& names, const Fitted& full, size_t k, Chosen& c) {
    const std::vector<int> rest = at_.all_but({k});
    const Subset s = now.subset(rest);
    const Fitted without = now.evaluate(s);
    for (Option& o : options_.best_terms(now, s, names, without.score - full.score, [&](const Term& t) {
           return !at_.is_chosen(t) && t.kind != TermKind::kCurve && at_.shares_joint(t, {k});
         })) {
      if (!std::isfinite(o.value)) break;
      const Gain g = now.gain(full, o.fit);
      if (g.sum + o.term.price - c.term.price < 2.0 * g.error && without.score - o.fit.score > 0.0)
        c.rivals.push_back({o.term, g.sum, without.score - o.fit.score});
    }
    c.rivals.resize(std::min(c.rivals.size(), kMostRivals));
  }

  void find_refused(const Round& now, const Subset& s, const Fitted& full, const std::vector<Beside>& names, SearchResult& out) {
    std::map<std::string, Refused> best;
    for (const Beside& one : names) {
      const Term& t = one.term;
      if (at_.is_chosen(t)) continue;
      const double gain = now.training_gain(s, one.cross);
      const Refused refused{t, gain, 0.0, false, gain < 0.0};
      const auto at = best.find(t.place);
      if (at == best.end() || at->second.gain < gain) best[t.place] = refused;
    }
    std::vector<Refused> all;
    for (auto& [place, one] : best) all.push_back(one);
    std::stable_sort(all.begin(), all.end(), [](const Refused& a, const Refused& b) { return a.gain > b.gain; });
    std::vector<Refused> shown(all.begin(), all.begin() + static_cast<long>(std::min(all.size(), kMostRefused)));
    parallel_for(static_cast<int>(shown.size()), request_.threads, [&](int k) {
      if (shown[k].collinear) return;
      const Option o = options_.option(now, s, shown[k].term);
      const Gain g = now.gain(o.fit, full);
      shown[k].impossible = !std::isfinite(o.value);
      shown[k].gain = g.sum;
      shown[k].error = g.error;
    });
    for (size_t k = shown.size(); k < all.size(); ++k) {
      if (all[k].collinear) shown.push_back(all[k]);
    }
    out.refused = std::move(shown);
  }

  Present& at_;
  Options& options_;
  const SearchRequest& request_;
};

}  // namespace

SearchResult outcome_of(Present& at, Options& options, const SearchRequest& request) {
  return Outcome(at, options, request).write();
}

}  // namespace veridyn::search
