#include "selection.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <unordered_map>

#include "bordered_fit.hpp"
#include "veridyn/math/parallel.hpp"
#include "veridyn/math/student_t.hpp"

namespace veridyn {
namespace {

constexpr double kAbsorbed =
    1e-6;  // share of a column's square that must be new for the data to answer
constexpr double kImpossible = 1.2;  // a parameter may seem to fall by this share of itself
constexpr double kOwnCause = 0.5;
constexpr double kListedOnJoint = 0.4;
constexpr double kListed = 0.6;  // of the gain: rivals are named, with what they gain
constexpr int kTested = 6;       // best candidates that get a Wald test in every round

// Clusters that are left out together.
std::vector<std::vector<int>> make_folds(const NormalBlocks& data) {
  int recordings = 0;
  for (int c = 0; c < data.clusters(); ++c)
    recordings = std::max(recordings, data.recording_of(c) + 1);
  std::vector<std::vector<int>> folds;
  if (recordings == 1) {
    for (int c = 0; c < data.clusters(); ++c) folds.push_back({c});
    return folds;
  }
  folds.resize(static_cast<size_t>(recordings));
  for (int c = 0; c < data.clusters(); ++c)
    folds[static_cast<size_t>(data.recording_of(c))].push_back(c);
  return folds;
}

NormalBlocks::Sums summed(const NormalBlocks& data, const std::vector<int>& clusters) {
  NormalBlocks::Sums out = data.cluster(clusters.front());
  for (size_t k = 1; k < clusters.size(); ++k) {
    const NormalBlocks::Sums& next = data.cluster(clusters[k]);
    for (size_t j = 0; j < out.G.size(); ++j) {
      out.G[j] += next.G[j];
      out.g[j] += next.g[j];
    }
    out.b2 += next.b2;
    out.rows += next.rows;
  }
  return out;
}

VectorXd joint_weights(const NormalBlocks& data, const ColumnSet& set) {
  const NormalBlocks::Sums& all = data.total();
  VectorXd w = all.rows.array() / all.b2.array().max(1e-300);
  for (int round = 0; round < 2; ++round) {
    const VectorXd x = data.solve(set, w, all, nullptr);
    w = all.rows.array() /
        data.residual2(set, x, all).array().max(1e-12 * all.b2.array().max(1e-290));
  }
  return w;
}

// Mean square of every joint on a fold, from the others.
VectorXd held_out_error(const NormalBlocks& data, const ColumnSet& set, const VectorXd& w,
                        const NormalBlocks::Sums& fold) {
  const VectorXd x = data.solve(set, w, data.total(), &fold);
  return data.residual2(set, x, fold).array() / fold.rows.array().max(1.0);
}

double log_fall(const VectorXd& before, const VectorXd& after) {
  return (before.array().max(1e-300).log() - after.array().max(1e-300).log()).sum();
}

// Of the columns of a body those that the others do not span, first ones first.
ColumnSet independent(const NormalBlocks& data, const ColumnSet& all) {
  const auto k = static_cast<Eigen::Index>(all.size());
  MatrixXd S = MatrixXd::Zero(k, k);
  for (const MatrixXd& G : data.total().G) {
    for (Eigen::Index r = 0; r < k; ++r) {
      for (Eigen::Index c = 0; c < k; ++c)
        S(r, c) += G(all[static_cast<size_t>(r)], all[static_cast<size_t>(c)]);
    }
  }
  // First moments pin a small load best, then inertia, mass last.
  ColumnSet out;
  const VectorXd diagonal = S.diagonal();
  for (Eigen::Index at = 1; at <= k; ++at) {
    const Eigen::Index c = at % k;
    if (S(c, c) <= kAbsorbed * diagonal[c]) continue;
    out.push_back(all[static_cast<size_t>(c)]);
    const VectorXd column = S.col(c);
    S -= column * column.transpose() / column[c];
  }
  return out;
}

class Selector {
 public:
  Selector(const NormalBlocks& data, const ColumnSet& base,
           const std::vector<Hypothesis>& hypotheses, const DiagnosisOptions& options)
      : data_(data), base_(base), hypotheses_(hypotheses), options_(options) {
    for (const auto& fold : make_folds(data)) folds_.push_back(summed(data, fold));
    for (const Hypothesis& h : hypotheses) columns_.push_back(columns_of(data, h));
    std::set<std::string> families;
    for (const Hypothesis& h : hypotheses) families.insert(h.family);
    families_ = static_cast<double>(std::max<size_t>(1, families.size()));
  }

  Selection accept_all() {
    for (size_t h = 0; h < hypotheses_.size(); ++h) {
      Evidence e;
      e.hypothesis = static_cast<int>(h);
      accepted_.push_back({e, {}});
    }
    return fitted();
  }

  std::vector<int> drop_until_needed() {
    for (size_t h = 0; h < hypotheses_.size(); ++h) {
      Evidence e;
      e.hypothesis = static_cast<int>(h);
      accepted_.push_back({e, {}});
    }
    while (!accepted_.empty()) {
      size_t weakest = accepted_.size();
      double least = 1e300;
      for (size_t k = 0; k < accepted_.size(); ++k) {
        std::vector<int> others = chosen();
        const int own = others[k];
        others.erase(others.begin() + static_cast<long>(k));
        const Evidence e = ask(own, *stand(others));
        const double worth = e.absorbed ? -1e300 : e.gain;
        if (passes(e) || worth >= least) continue;
        least = worth;
        weakest = k;
      }
      if (weakest == accepted_.size()) break;
      accepted_.erase(accepted_.begin() + static_cast<long>(weakest));
    }
    return chosen();
  }

  Selection run(const std::vector<int>& initial) {
    for (const int h : initial) {
      Evidence e;
      e.hypothesis = h;
      accepted_.push_back({e, {}});
    }
    while (static_cast<int>(accepted_.size()) < options_.max_effects && add_one())
      swap_early_ones();
    drop_superfluous();
    return finish();
  }

 private:
  // The accepted columns, factored on all rows and on the rows outside of every fold.
  struct Stand {
    ColumnSet set;
    VectorXd weights;
    std::unique_ptr<BorderedFit> all;
    std::vector<BorderedFit> folds;
  };

  // The largest p value that counts. One recording gives eight clusters only: the folds decide
  // there, except for what one motion cannot show; the names are provisional.
  double limit(int h) const {
    const Hypothesis& hypothesis = hypotheses_[static_cast<size_t>(h)];
    const bool strict = several_recordings() || hypothesis.extrapolates;
    return options_.significance / ((strict ? families_ : 1.0) * hypothesis.tried);
  }

  bool several_recordings() const { return data_.recording_of(data_.clusters() - 1) > 0; }

  ColumnSet set_with(const std::vector<int>& chosen) const {
    ColumnSet set = base_;
    for (const int h : chosen)
      set.insert(set.end(), columns_[static_cast<size_t>(h)].begin(),
                 columns_[static_cast<size_t>(h)].end());
    return set;
  }

  VectorXd weights(const ColumnSet& set) const { return joint_weights(data_, set); }

  std::unique_ptr<Stand> stand(const std::vector<int>& chosen) const {
    auto out = std::make_unique<Stand>();
    out->set = set_with(chosen);
    out->weights = weights(out->set);
    out->all =
        std::make_unique<BorderedFit>(out->set, out->weights, data_.total(), nullptr, nullptr);
    out->folds.reserve(folds_.size());
    for (const auto& fold : folds_)
      out->folds.emplace_back(out->set, out->weights, data_.total(), &fold, &fold);
    return out;
  }

  // Everything but the Wald test.
  Evidence ask(int h, const Stand& before) const {
    Evidence e;
    e.hypothesis = h;
    const Hypothesis& hypothesis = hypotheses_[static_cast<size_t>(h)];
    const ColumnSet& own = columns_[static_cast<size_t>(h)];
    if (own.empty()) {
      e.absorbed = true;
      return e;
    }
    const BorderedFit::Border whole = before.all->with(own);
    if (whole.new_share < kAbsorbed) {
      e.absorbed = true;
      return e;
    }
    for (size_t k = 0; k < own.size(); ++k) {
      const double value = whole.values[static_cast<Eigen::Index>(k)];
      const bool nonnegative =
          hypothesis.body < 0 && hypothesis.signs[k] == ParameterSign::kNonnegative;
      const double scale = std::max(data_.scale()[own[k]], 1e-300);
      const bool absurd = std::abs(value) / scale > hypothesis.largest_value;
      const bool impossible =
          k < hypothesis.lowest.size() && value / scale < kImpossible * hypothesis.lowest[k];
      e.sign_broken = e.sign_broken || impossible || (nonnegative && value < 0.0) || absurd;
    }
    // The mean over folds and not the fall of the pooled error: one recording with a fault of its
    // own must not outvote the others.
    int better = 0;
    for (const BorderedFit& fold : before.folds) {
      const double d = log_fall(fold.residual2(), fold.with(own).residual2);
      e.gain += d / static_cast<double>(folds_.size());
      better += static_cast<int>(d > 0.0);
    }
    e.fold_share = static_cast<double>(better) / static_cast<double>(folds_.size());
    return e;
  }

  // Solutions without one cluster each, over the set; (set x clusters).
  MatrixXd jackknife(const ColumnSet& set, const VectorXd& w) const {
    MatrixXd out(static_cast<Eigen::Index>(set.size()), data_.clusters());
    for (int c = 0; c < data_.clusters(); ++c)
      out.col(c) = data_.solve(set, w, data_.total(), &data_.cluster(c));
    return out;
  }

  static VectorXd deviations(const MatrixXd& solutions) {
    const auto g = static_cast<double>(solutions.cols());
    const VectorXd mean = solutions.rowwise().mean();
    return ((solutions.colwise() - mean).rowwise().squaredNorm() * ((g - 1.0) / g)).cwiseSqrt();
  }

  // The accepted columns on the rows outside of every cluster.
  std::vector<BorderedFit> without_clusters(const Stand& before) const {
    std::vector<BorderedFit> out;
    out.reserve(static_cast<size_t>(data_.clusters()));
    for (int c = 0; c < data_.clusters(); ++c)
      out.emplace_back(before.set, before.weights, data_.total(), &data_.cluster(c), nullptr);
    return out;
  }

  double p_value(int h, const Stand& before, const std::vector<BorderedFit>& left_out) const {
    const ColumnSet& columns = columns_[static_cast<size_t>(h)];
    if (columns.empty()) return 1.0;
    const VectorXd x = before.all->with(columns).values;
    MatrixXd solutions(x.size(), data_.clusters());
    for (int c = 0; c < data_.clusters(); ++c)
      solutions.col(c) = left_out[static_cast<size_t>(c)].with(columns).values;
    const VectorXd std = deviations(solutions);
    const Eigen::Index own = x.size();
    double best = 1.0;
    for (Eigen::Index k = 0; k < own; ++k) {
      best = std::min(best, student_t_two_sided(x[k] / std::max(std[k], 1e-300),
                                                std::max(1, data_.clusters() - 1)));
    }
    best = std::min(1.0, best * static_cast<double>(own));
    if (own == 1 || 3 * own >= data_.clusters()) return best;
    return std::min(1.0, 2.0 * std::min(best, wald(x, solutions)));
  }

  // All parameters together, by Hotelling's statistic: parameters that share one cause may each be
  // uncertain while their sum is not.
  static double wald(const VectorXd& x, const MatrixXd& solutions) {
    const auto g = static_cast<double>(solutions.cols());
    const auto k = static_cast<double>(x.size());
    const MatrixXd centred = solutions.colwise() - solutions.rowwise().mean();
    MatrixXd S = centred * centred.transpose() * ((g - 1.0) / g);
    S.diagonal() *= 1.0 + 1e-9;
    const double T2 = x.dot(S.ldlt().solve(x));
    return fisher_f_upper_tail(T2 * (g - k) / (k * (g - 1.0)), k, g - k);
  }

  std::vector<Evidence> ask_all(const std::vector<int>& chosen) const {
    const std::unique_ptr<Stand> before = stand(chosen);
    std::vector<Evidence> all(hypotheses_.size());
    parallel_for(static_cast<int>(hypotheses_.size()), options_.identification.threads, [&](int h) {
      const bool taken = std::find(chosen.begin(), chosen.end(), h) != chosen.end();
      if (!taken) all[static_cast<size_t>(h)] = ask(h, *before);
      all[static_cast<size_t>(h)].hypothesis = h;
      all[static_cast<size_t>(h)].absorbed = taken || all[static_cast<size_t>(h)].absorbed;
    });
    return all;
  }

  bool passes(const Evidence& e) const {
    // One fold may disagree: a recording can have a fault of its own.
    const auto folds = static_cast<double>(folds_.size());
    const double allowed = std::max(folds >= 4.0 ? 1.0 : 0.0, (1.0 - options_.fold_share) * folds);
    return !e.absorbed && !e.sign_broken && e.gain > options_.smallest_gain &&
           (1.0 - e.fold_share) * folds <= allowed + 1e-9;
  }

  std::vector<int> chosen() const {
    std::vector<int> out;
    for (const Accepted& a : accepted_) out.push_back(a.evidence.hypothesis);
    return out;
  }

  // Of candidates in a tie the earlier stage wins, then the fewer parameters.
  bool asked_earlier(const Evidence& a, const Evidence& b) const {
    const Hypothesis& ha = hypotheses_[static_cast<size_t>(a.hypothesis)];
    const Hypothesis& hb = hypotheses_[static_cast<size_t>(b.hypothesis)];
    if (ha.stage != hb.stage) return ha.stage < hb.stage;
    if (ha.columns.size() != hb.columns.size()) return ha.columns.size() < hb.columns.size();
    return a.gain > b.gain;
  }

  bool add_one() {
    std::vector<Evidence> all = ask_all(chosen());
    std::vector<Evidence> good;
    for (const Evidence& e : all) {
      if (passes(e)) good.push_back(e);
    }
    std::sort(good.begin(), good.end(),
              [](const Evidence& a, const Evidence& b) { return a.gain > b.gain; });
    const std::unique_ptr<Stand> before = stand(chosen());
    const std::vector<BorderedFit> left_out = without_clusters(*before);
    std::vector<Evidence> sure;
    int tested = 0;
    for (Evidence& e : good) {
      if (tested++ >= kTested + static_cast<int>(sure.size()) ||
          (!sure.empty() && e.gain < options_.rival_share * sure.front().gain))
        break;
      e.p_value = p_value(e.hypothesis, *before, left_out);
      if (e.p_value < limit(e.hypothesis)) sure.push_back(e);
    }
    if (sure.empty()) return false;
    Evidence best = sure.front();
    for (const Evidence& e : sure) {
      // A tie between families goes to the earlier question; within one family to the larger gain.
      if (e.gain > 0.95 * sure.front().gain && asked_earlier(e, best)) best = e;
    }
    accepted_.push_back({best, {}});
    return true;
  }

  // An early choice gives way if another hypothesis does clearly better beside the later ones.
  void swap_early_ones() {
    for (size_t k = 0; k + 1 < accepted_.size(); ++k) {
      std::vector<int> others = chosen();
      const int own = others[k];
      others.erase(others.begin() + static_cast<long>(k));
      const std::vector<Evidence> all = ask_all(others);
      Evidence best = all[static_cast<size_t>(own)];
      const double needed = std::max(best.gain, 0.0) + options_.smallest_gain;
      for (const Evidence& e : all) {
        if (passes(e) && e.gain > std::max(needed, best.gain)) best = e;
      }
      if (best.hypothesis == own) continue;
      const std::unique_ptr<Stand> beside = stand(others);
      best.p_value = p_value(best.hypothesis, *beside, without_clusters(*beside));
      if (best.p_value < limit(best.hypothesis)) accepted_[k].evidence = best;
    }
  }

  void drop_superfluous() {
    for (size_t k = accepted_.size(); k-- > 0;) {
      std::vector<int> others = chosen();
      const int own = others[k];
      others.erase(others.begin() + static_cast<long>(k));
      const std::unique_ptr<Stand> beside = stand(others);
      const Evidence e = ask(own, *beside);
      if (!passes(e)) {
        accepted_.erase(accepted_.begin() + static_cast<long>(k));
      } else {
        accepted_[k].evidence.p_value = std::min(accepted_[k].evidence.p_value,
                                                 p_value(own, *beside, without_clusters(*beside)));
      }
    }
  }

  // Of the best hypothesis of every family that was asked and not accepted.
  void give_p_values(std::vector<Evidence>& asked) const {
    std::map<std::string, Evidence*> best;
    for (Evidence& e : asked) {
      if (e.absorbed) continue;
      Evidence*& of_family = best[hypotheses_[static_cast<size_t>(e.hypothesis)].family];
      if (of_family == nullptr || of_family->gain < e.gain) of_family = &e;
    }
    std::vector<Evidence*> list;
    for (const auto& [family, e] : best) list.push_back(e);
    const std::unique_ptr<Stand> with = stand(chosen());
    const std::vector<BorderedFit> left_out = without_clusters(*with);
    parallel_for(static_cast<int>(list.size()), options_.identification.threads, [&](int k) {
      Evidence& e = *list[static_cast<size_t>(k)];
      e.p_value = p_value(e.hypothesis, *with, left_out);
    });
  }

  // Rivals of an accepted hypothesis gain as much in its place, beside all others, and little once
  // it is there: they explain the same. What still gains is a cause of its own.
  void find_rivals(Selection& out) const {
    const std::vector<int> all = chosen();
    for (size_t k = 0; k < all.size(); ++k) {
      std::vector<int> others = all;
      others.erase(others.begin() + static_cast<long>(k));
      const std::vector<Evidence> instead = ask_all(others);
      const double own = instead[static_cast<size_t>(all[k])].gain;
      std::set<std::string> named = {hypotheses_[static_cast<size_t>(all[k])].family};
      std::vector<Evidence> rivals;
      for (const Evidence& e : instead) {
        const Evidence& left = out.last_asked[static_cast<size_t>(e.hypothesis)];
        const bool same = left.absorbed || left.gain < kOwnCause * e.gain;
        const bool taken = std::find(all.begin(), all.end(), e.hypothesis) != all.end();
        const bool one_joint = hypotheses_[static_cast<size_t>(e.hypothesis)].joint ==
                               hypotheses_[static_cast<size_t>(all[k])].joint;
        const double least = one_joint ? kListedOnJoint : kListed;
        if (!taken && same && passes(e) && e.gain >= least * own) rivals.push_back(e);
      }
      std::sort(rivals.begin(), rivals.end(),
                [](const Evidence& a, const Evidence& b) { return a.gain > b.gain; });
      out.accepted[k].rivals.clear();
      out.accepted[k].evidence.gain = own;
      for (const Evidence& e : rivals) {
        if (named.insert(hypotheses_[static_cast<size_t>(e.hypothesis)].family).second)
          out.accepted[k].rivals.push_back(e);
      }
    }
  }

  Selection finish() {
    Selection out = fitted();
    out.last_asked = ask_all(chosen());
    find_rivals(out);
    give_p_values(out.last_asked);
    return out;
  }

  Selection fitted() const {
    Selection out;
    out.accepted = accepted_;
    out.columns = set_with(chosen());
    const VectorXd w = weights(out.columns);
    const VectorXd x = data_.solve(out.columns, w, data_.total(), nullptr);
    out.degrees_of_freedom = std::max(1, data_.clusters() - 1);
    const VectorXd std = safe_deviations(out.columns, w, out.degrees_of_freedom);
    out.values.resize(x.size());
    out.standard_deviations.resize(x.size());
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      const double scale = std::max(data_.scale()[out.columns[static_cast<size_t>(k)]], 1e-300);
      out.values[k] = x[k] / scale;
      out.standard_deviations[k] = std[k] / scale;
    }
    return out;
  }

  // The larger of two jackknifes: over clusters, and over whole recordings where there are several,
  // for what is systematic to one motion shows only there. As deviations for t with `freedom`.
  VectorXd safe_deviations(const ColumnSet& set, const VectorXd& w, double freedom) const {
    VectorXd std = deviations(jackknife(set, w));
    if (!several_recordings() || folds_.size() < 3) return std;
    MatrixXd without(static_cast<Eigen::Index>(set.size()),
                     static_cast<Eigen::Index>(folds_.size()));
    for (size_t f = 0; f < folds_.size(); ++f)
      without.col(static_cast<Eigen::Index>(f)) = data_.solve(set, w, data_.total(), &folds_[f]);
    const double recordings = static_cast<double>(folds_.size()) - 1.0;
    const double wider = student_t_quantile(0.05, recordings) / student_t_quantile(0.05, freedom);
    return std.cwiseMax(wider * deviations(without));
  }

  const NormalBlocks& data_;
  const ColumnSet& base_;
  const std::vector<Hypothesis>& hypotheses_;
  const DiagnosisOptions& options_;
  std::vector<NormalBlocks::Sums> folds_;
  std::vector<ColumnSet> columns_;
  double families_ = 1.0;
  std::vector<Accepted> accepted_;
};

}  // namespace

double fold_gain(const NormalBlocks& before, const ColumnSet& base_before,
                 const NormalBlocks& after, const ColumnSet& base_after) {
  const VectorXd w_before = joint_weights(before, base_before);
  const VectorXd w_after = joint_weights(after, base_after);
  const auto folds = make_folds(before);
  double sum = 0.0;
  for (const auto& fold : folds) {
    sum += log_fall(held_out_error(before, base_before, w_before, summed(before, fold)),
                    held_out_error(after, base_after, w_after, summed(after, fold)));
  }
  return sum / static_cast<double>(folds.size());
}

ColumnSet columns_of(const NormalBlocks& data, const Hypothesis& hypothesis) {
  ColumnSet out;
  for (const std::string& name : hypothesis.columns) {
    for (int k = 0; k < data.columns(); ++k) {
      if (data.names()[static_cast<size_t>(k)] == name && data.scale()[k] > 0.0) out.push_back(k);
    }
  }
  return hypothesis.body >= 0 ? independent(data, out) : out;
}

VectorXd residual_weights(const NormalBlocks& data, const ColumnSet& set) {
  return joint_weights(data, set);
}

Selection refit(const NormalBlocks& data, const ColumnSet& base,
                const std::vector<Hypothesis>& hypotheses, const DiagnosisOptions& options) {
  return Selector(data, base, hypotheses, options).accept_all();
}

std::vector<int> still_needed(const NormalBlocks& data, const ColumnSet& base,
                              const std::vector<Hypothesis>& hypotheses,
                              const DiagnosisOptions& options) {
  return Selector(data, base, hypotheses, options).drop_until_needed();
}

Selection select_effects(const NormalBlocks& data, const ColumnSet& base,
                         const std::vector<Hypothesis>& hypotheses, const DiagnosisOptions& options,
                         const std::vector<int>& initial) {
  return Selector(data, base, hypotheses, options).run(initial);
}

}  // namespace veridyn
