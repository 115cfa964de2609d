#include "diagnosis/evidence/selection.hpp"

#include <algorithm>
#include <map>
#include <memory>
#include <numeric>
#include <set>
#include <string>

#include "diagnosis/evidence/numerics.hpp"
#include "math/parallel.hpp"

namespace veridyn {
namespace {

class Selector {
 public:
  Selector(const NormalBlocks& data, const ColumnSet& base,
           const std::vector<Hypothesis>& hypotheses, const DiagnosisOptions& options,
           const std::vector<int>& initial)
      : examiner_(data, base, hypotheses, options), options_(options) {
    for (const int h : initial) {
      Evidence e;
      e.hypothesis = h;
      accepted_.push_back({e});
    }
  }

  // The accepted ones, fitted together.
  Selection fitted() const {
    Selection out;
    out.accepted = accepted_;
    out.columns = examiner_.set_with(chosen());
    const NormalBlocks& data = examiner_.data();
    const VectorXd w = joint_weights(data, out.columns);
    const VectorXd prior = examiner_.prior(chosen());
    const VectorXd x = data.solve(out.columns, w, data.total(), nullptr, prior);
    out.degrees_of_freedom = std::max(1, data.clusters() - 1);
    const VectorXd std = examiner_.deviations(out.columns, w, out.degrees_of_freedom, prior);
    out.values.resize(x.size());
    out.standard_deviations.resize(x.size());
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      const double scale = std::max(data.scale()[out.columns[k]], numerics::kTiny);
      out.values[k] = x[k] / scale;
      out.standard_deviations[k] = std[k] / scale;
    }
    return out;
  }

  std::vector<int> drop_until_needed() {
    while (!accepted_.empty()) {
      size_t weakest = accepted_.size();
      double least = numerics::kHuge;
      for (size_t k = 0; k < accepted_.size(); ++k) {
        std::vector<int> others = chosen();
        const int own = others[k];
        others.erase(others.begin() + static_cast<long>(k));
        const Evidence e = examiner_.evaluate(own, *examiner_.baseline(others));
        const double worth = e.collinear ? -numerics::kHuge : e.gain;
        if (examiner_.stays(e) || worth >= least) continue;
        least = worth;
        weakest = k;
      }
      if (weakest == accepted_.size()) break;
      accepted_.erase(accepted_.begin() + static_cast<long>(weakest));
    }
    return chosen();
  }

  // The initially accepted hypotheses without superfluous ones, by their gain beside the others.
  Selection needed() {
    do {
      drop_until_needed();
    } while (drop_uncertain());
    for (Accepted& a : accepted_) {
      std::vector<int> others = chosen();
      others.erase(std::find(others.begin(), others.end(), a.evidence.hypothesis));
      const double p = a.evidence.p_value;
      a.evidence = examiner_.evaluate(a.evidence.hypothesis, *examiner_.baseline(others));
      a.evidence.p_value = p;
    }
    std::stable_sort(accepted_.begin(), accepted_.end(), [](const Accepted& a, const Accepted& b) {
      return a.evidence.gain > b.evidence.gain;
    });
    return fitted();
  }

  Selection run() {
    swap(accepted_.size());
    do {
      while (static_cast<int>(accepted_.size()) < options_.max_effects && add_one())
        swap(accepted_.size() - 1);
    } while (drop_superfluous());
    return finish();
  }

 private:
  std::vector<int> chosen() const {
    std::vector<int> out;
    for (const Accepted& a : accepted_) out.push_back(a.evidence.hypothesis);
    return out;
  }

  // In a tie the earlier stage wins, then the smaller number of parameters.
  bool asked_earlier(const Evidence& a, const Evidence& b) const {
    const Hypothesis& ha = examiner_.hypothesis(a.hypothesis);
    const Hypothesis& hb = examiner_.hypothesis(b.hypothesis);
    if (ha.stage != hb.stage) return ha.stage < hb.stage;
    if (ha.columns.size() != hb.columns.size()) return ha.columns.size() < hb.columns.size();
    return a.gain > b.gain;
  }

  bool may_be_taken(const Evidence& e) const {
    return examiner_.passes(e) && dropped_.count(e.hypothesis) == 0;
  }

  bool add_one() {
    const std::vector<Evidence>& all = examiner_.evaluate_all(chosen());
    std::vector<Evidence> good;
    for (const Evidence& e : all) {
      if (may_be_taken(e)) good.push_back(e);
    }
    std::sort(good.begin(), good.end(),
              [](const Evidence& a, const Evidence& b) { return a.gain > b.gain; });
    const std::unique_ptr<Examiner::BaselineFit> before = examiner_.baseline(chosen());
    const std::vector<BorderedFit> without_cluster = examiner_.without_clusters(*before);
    std::vector<Evidence> sure;
    int tested = 0;
    for (Evidence& e : good) {
      if (tested++ >= static_cast<int>(options_.thresholds.tested_candidates) + static_cast<int>(sure.size()) ||
          (!sure.empty() && e.gain < options_.thresholds.rival_share * sure.front().gain))
        break;
      e.p_value = examiner_.p_value(e.hypothesis, *before, without_cluster);
      if (e.p_value < examiner_.limit(e.hypothesis)) sure.push_back(e);
    }
    if (sure.empty()) return false;
    Evidence best = sure.front();
    for (const Evidence& e : sure) {
      // Between candidates the earlier test wins a tie; within one the larger gain.
      if (e.gain > options_.thresholds.tie * sure.front().gain && asked_earlier(e, best)) best = e;
    }
    if (!take_changed_friction(best, *before)) accepted_.push_back({best});
    return true;
  }

  // Level and damping of a joint's friction change together from one day to the next, and each alone explains less
  // than another law of friction through both. They are one question where that law is the best answer: with the
  // larger gain of the two, and each of them certain beside the other, both are accepted in its place.
  bool take_changed_friction(const Evidence& best, const Examiner::BaselineFit& before) {
    const Hypothesis& law = examiner_.hypothesis(best.hypothesis);
    if (!law.joint || is_plain_friction(law) || static_cast<int>(accepted_.size()) + 2 > options_.max_effects) return false;
    for (int first = 0; first < examiner_.hypotheses(); ++first) {
      for (int second = first + 1; second < examiner_.hypotheses(); ++second) {
        if (!is_changed_friction(first, *law.joint) || !is_changed_friction(second, *law.joint) ||
            examiner_.hypothesis(first).axis.coefficients != examiner_.hypothesis(second).axis.coefficients)
          continue;
        std::vector<Accepted> both = {{beside(first, second)}, {beside(second, first)}};
        if (!are_sure(both) || examiner_.gain_of({first, second}, before) <= best.gain) continue;
        if (both[0].evidence.gain < both[1].evidence.gain) std::swap(both[0], both[1]);
        accepted_.insert(accepted_.end(), both.begin(), both.end());
        return true;
      }
    }
    return false;
  }

  static bool is_plain_friction(const Hypothesis& h) {
    return is_friction(effect_of(h.cause)) && find_effect(effect_of(h.cause)).traits().elementary;
  }

  bool is_changed_friction(int h, JointIndex joint) const {
    const Hypothesis& hypothesis = examiner_.hypothesis(h);
    const std::vector<int> taken = chosen();
    return is_change(hypothesis) && hypothesis.joint == joint && is_plain_friction(hypothesis) &&
           std::find(taken.begin(), taken.end(), h) == taken.end();
  }

  // Evidence for a hypothesis beside the chosen ones and another.
  Evidence beside(int h, int other) const {
    std::vector<int> others = chosen();
    others.push_back(other);
    const std::unique_ptr<Examiner::BaselineFit> fit = examiner_.baseline(others);
    Evidence e = examiner_.evaluate(h, *fit);
    if (may_be_taken(e)) e.p_value = examiner_.p_value(h, *fit, examiner_.without_clusters(*fit));
    return e;
  }

  bool are_sure(const std::vector<Accepted>& all) const {
    return std::all_of(all.begin(), all.end(), [this](const Accepted& a) {
      return may_be_taken(a.evidence) && a.evidence.p_value < examiner_.limit(a.evidence.hypothesis);
    });
  }

  // Replaces an early choice if another hypothesis is clearly better beside the later ones.
  void swap(size_t early) {
    for (size_t k = 0; k < early; ++k) {
      std::vector<int> others = chosen();
      const int own = others[k];
      others.erase(others.begin() + static_cast<long>(k));
      const std::vector<Evidence>& all = examiner_.evaluate_all(others);
      Evidence best = all[own];
      const double needed = std::max(best.gain, 0.0) + options_.thresholds.smallest_gain;
      for (const Evidence& e : all) {
        if (may_be_taken(e) && e.gain > std::max(needed, best.gain)) best = e;
      }
      if (best.hypothesis == own) continue;
      const std::unique_ptr<Examiner::BaselineFit> beside = examiner_.baseline(others);
      best.p_value =
          examiner_.p_value(best.hypothesis, *beside, examiner_.without_clusters(*beside));
      if (best.p_value < examiner_.limit(best.hypothesis)) accepted_[k].evidence = best;
    }
  }

  // Drops hypotheses that are superfluous beside later ones; they are not tested again. True if any
  // was dropped: hypotheses that it concealed may then be accepted.
  bool drop_superfluous() {
    const size_t before = accepted_.size();
    for (size_t k = accepted_.size(); k-- > 0;) {
      std::vector<int> others = chosen();
      const int own = others[k];
      others.erase(others.begin() + static_cast<long>(k));
      const std::unique_ptr<Examiner::BaselineFit> beside = examiner_.baseline(others);
      const Evidence e = examiner_.evaluate(own, *beside);
      const double p = examiner_.p_value(own, *beside, examiner_.without_clusters(*beside));
      if (!examiner_.stays(e)) {
        dropped_.insert(own);
        accepted_.erase(accepted_.begin() + static_cast<long>(k));
      } else {
        accepted_[k].evidence.p_value = std::min(accepted_[k].evidence.p_value, p);
      }
    }
    return accepted_.size() < before;
  }

  // Drops the least certain hypothesis if it is not significant. True if one was dropped.
  bool drop_uncertain() {
    size_t worst = accepted_.size();
    double most = 0.0;
    for (size_t k = 0; k < accepted_.size(); ++k) {
      std::vector<int> others = chosen();
      const int own = others[k];
      others.erase(others.begin() + static_cast<long>(k));
      const std::unique_ptr<Examiner::BaselineFit> beside = examiner_.baseline(others);
      double& p = accepted_[k].evidence.p_value;
      p = examiner_.p_value(own, *beside, examiner_.without_clusters(*beside));
      if (p < examiner_.limit(own) || p < most) continue;
      most = p;
      worst = k;
    }
    if (worst == accepted_.size()) return false;
    accepted_.erase(accepted_.begin() + static_cast<long>(worst));
    return true;
  }

  // Computes p values of the best hypothesis of every candidate that was tested and not accepted.
  void give_p_values(std::vector<Evidence>& asked) const {
    std::map<Candidate, Evidence*> best;
    for (Evidence& e : asked) {
      if (e.accepted || e.collinear) continue;
      Evidence*& of_candidate = best[examiner_.hypothesis(e.hypothesis)];
      if (of_candidate == nullptr || of_candidate->gain < e.gain) of_candidate = &e;
    }
    std::vector<Evidence*> list;
    for (const auto& [candidate, e] : best) list.push_back(e);
    const std::unique_ptr<Examiner::BaselineFit> with = examiner_.baseline(chosen());
    const std::vector<BorderedFit> without_cluster = examiner_.without_clusters(*with);
    parallel_for(static_cast<int>(list.size()), options_.identification.threads, [&](int k) {
      Evidence& e = *list[k];
      e.p_value = examiner_.p_value(e.hypothesis, *with, without_cluster);
    });
  }

  // True if the accepted hypothesis is significant beside its rival as well, while the rival adds
  // nothing: the rival is then not the cause (encompassing test of non-nested models).
  bool refuted(const Evidence& rival, int own, std::vector<int> others) const {
    others.push_back(rival.hypothesis);
    const std::unique_ptr<Examiner::BaselineFit> beside = examiner_.baseline(others);
    const Evidence e = examiner_.evaluate(own, *beside);
    return examiner_.passes(e) && e.gain > options_.thresholds.refuting &&
           examiner_.p_value(own, *beside, examiner_.without_clusters(*beside)) <
               examiner_.limit(own);
  }

  // Rivals of an accepted hypothesis gain as much in its place, beside all others, and little once
  // it is there: they explain the same. What still gains is a cause of its own.
  void find_rivals(Selection& out) const {
    const std::vector<int> all = chosen();
    for (size_t k = 0; k < all.size(); ++k) {
      std::vector<int> others = all;
      others.erase(others.begin() + static_cast<long>(k));
      const std::vector<Evidence>& instead = examiner_.evaluate_all(others);
      const double own_gain = instead[all[k]].gain;
      std::set<Candidate> named = {examiner_.hypothesis(all[k])};
      std::vector<Evidence> rivals;
      for (const Evidence& e : instead) {
        const Evidence& left = out.last_evaluated[e.hypothesis];
        const bool same = left.collinear || left.gain < options_.thresholds.own_cause * e.gain;
        const bool one_joint =
            examiner_.hypothesis(e.hypothesis).joint == examiner_.hypothesis(all[k]).joint;
        const double least = one_joint ? options_.thresholds.rival_same_joint : options_.thresholds.rival_elsewhere;
        if (!left.accepted && same && examiner_.passes(e) && e.gain >= least * own_gain)
          rivals.push_back(e);
      }
      std::sort(rivals.begin(), rivals.end(),
                [](const Evidence& a, const Evidence& b) { return a.gain > b.gain; });
      out.accepted[k].rivals.clear();
      out.accepted[k].refuted.clear();
      out.accepted[k].evidence.gain = own_gain;
      for (const Evidence& e : rivals) {
        // Only the best hypothesis of each candidate is listed.
        if (!named.insert(examiner_.hypothesis(e.hypothesis)).second) continue;
        Accepted& own = out.accepted[k];
        (refuted(e, all[k], others) ? own.refuted : own.rivals).push_back(e);
      }
    }
  }

  Selection finish() {
    Selection out = fitted();
    out.last_evaluated = examiner_.evaluate_all(chosen());
    find_rivals(out);
    give_p_values(out.last_evaluated);
    return out;
  }

  Examiner examiner_;
  const DiagnosisOptions& options_;
  std::vector<Accepted> accepted_;
  std::set<int> dropped_;  // accepted once, superfluous later: each is tested only once
};

std::vector<int> all_of(const std::vector<Hypothesis>& hypotheses) {
  std::vector<int> out(hypotheses.size());
  std::iota(out.begin(), out.end(), 0);
  return out;
}

}  // namespace

Selection refit(const NormalBlocks& data, const ColumnSet& base,
                const std::vector<Hypothesis>& hypotheses, const DiagnosisOptions& options) {
  return Selector(data, base, hypotheses, options, all_of(hypotheses)).fitted();
}

std::vector<int> still_needed(const NormalBlocks& data, const ColumnSet& base,
                              const std::vector<Hypothesis>& hypotheses,
                              const DiagnosisOptions& options) {
  return Selector(data, base, hypotheses, options, all_of(hypotheses)).drop_until_needed();
}

Selection keep_needed(const NormalBlocks& data, const ColumnSet& base,
                      const std::vector<Hypothesis>& hypotheses, const DiagnosisOptions& options) {
  return Selector(data, base, hypotheses, options, all_of(hypotheses)).needed();
}

Selection select_effects(const NormalBlocks& data, const ColumnSet& base,
                         const std::vector<Hypothesis>& hypotheses, const DiagnosisOptions& options,
                         const std::vector<int>& initial) {
  return Selector(data, base, hypotheses, options, initial).run();
}

}  // namespace veridyn
