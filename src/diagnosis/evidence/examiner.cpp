#include "diagnosis/evidence/examiner.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <set>
#include <string>

#include "diagnosis/evidence/payload_fit.hpp"
#include "diagnosis/evidence/clustered_fit.hpp"
#include "diagnosis/evidence/numerics.hpp"
#include "math/parallel.hpp"
#include "math/signed_rank.hpp"
#include "math/student_t.hpp"

namespace veridyn {
namespace {

bool improve(const std::vector<double>& falls, const HoldOut& how) {
  const auto better = std::count_if(falls.begin(), falls.end(), [](double d) { return d > 0.0; });
  return how.enough_agree(static_cast<size_t>(better), falls.size());
}

// Columns of a body outside the span of the others, in their order.
ColumnSet independent(const NormalBlocks& data, const ColumnSet& all, double new_share) {
  const auto k = static_cast<Eigen::Index>(all.size());
  MatrixXd S = MatrixXd::Zero(k, k);
  for (const JointSquares& G : data.total().G) {
    for (Eigen::Index r = 0; r < k; ++r) {
      for (Eigen::Index c = 0; c < k; ++c)
        S(r, c) += G(all[r], all[c]);
    }
  }
  // First moments pin a small load best, then inertia, mass last.
  ColumnSet out;
  const VectorXd diagonal = S.diagonal();
  for (Eigen::Index at = 1; at <= k; ++at) {
    const Eigen::Index c = at % k;
    if (S(c, c) <= new_share * diagonal[c]) continue;
    out.push_back(all[c]);
    const VectorXd column = S.col(c);
    S -= column * column.transpose() / column[c];
  }
  return out;
}

// True for a smooth force over one position, of several terms.
bool is_force_of_position(const Hypothesis& h) {
  if (!std::holds_alternative<NewEffect>(h.cause) || !has_effect(effect_of(h.cause))) return false;
  const EffectTraits traits = find_effect(effect_of(h.cause)).traits();
  return traits.role == EffectRole::kForce && traits.uses_position && traits.depends_on_position && !traits.uses_velocity;
}

// True if any of the columns is not zero there. A fold in which an end stop is never touched says nothing about it.
bool acts_in(const ColumnSet& columns, const NormalBlocks::Sums& fold) {
  return std::any_of(columns.begin(), columns.end(), [&fold](int c) {
    return std::any_of(fold.G.begin(), fold.G.end(), [c](const JointSquares& G) { return G(c, c) > numerics::kNoise; });
  });
}

}  // namespace

ColumnSet columns_of(const NormalBlocks& data, const Hypothesis& hypothesis) {
  ColumnSet out;
  for (const std::string& name : hypothesis.columns) {
    for (int k = 0; k < data.columns(); ++k) {
      if (data.names()[k] == name && data.scale()[k] > 0.0) out.push_back(k);
    }
  }
  return is_load(hypothesis) ? independent(data, out, numerics::kLoadRank) : out;
}

Examiner::Examiner(const NormalBlocks& data, const ColumnSet& base,
                   const std::vector<Hypothesis>& hypotheses, const DiagnosisOptions& options)
    : data_(data), base_(base), hypotheses_(hypotheses), options_(options) {
  for (const auto& fold : make_folds(data, hold_out(options.thresholds))) {
    if (fold.size() > 1) sums_.push_back(summed(data, fold));
    folds_.push_back(fold.size() > 1 ? &sums_.back() : &data.cluster(fold.front()));
  }
  for (const Hypothesis& h : hypotheses) columns_.push_back(columns_of(data, h));
  const std::set<Candidate> asked(hypotheses.begin(), hypotheses.end());
  asked_ = static_cast<double>(std::max<size_t>(1, asked.size()));
}

// A single recording has only eight clusters: the folds decide there, except for causes that one
// motion can imitate; the names are provisional.
double Examiner::limit(int h) const {
  const Hypothesis& hypothesis = hypotheses_[h];
  const bool strict = several_recordings() || hypothesis.extrapolates;
  return options_.thresholds.significance / ((strict ? asked_ : 1.0) * hypothesis.tried);
}

ColumnSet Examiner::set_with(const std::vector<int>& chosen) const {
  ColumnSet set = base_;
  for (const int h : chosen)
    set.insert(set.end(), columns_[h].begin(),
               columns_[h].end());
  return set;
}

std::unique_ptr<Examiner::BaselineFit> Examiner::baseline(const std::vector<int>& chosen) const {
  auto out = std::make_unique<BaselineFit>();
  out->set = set_with(chosen);
  out->weights = joint_weights(data_, out->set);
  out->all = std::make_unique<BorderedFit>(out->set, out->weights, data_.total(), nullptr, nullptr);
  out->folds.reserve(folds_.size());
  for (const NormalBlocks::Sums* fold : folds_)
    out->folds.emplace_back(out->set, out->weights, data_.total(), fold, fold);
  return out;
}

// Among several parameters one may be zero: its sign counts if it exceeds the scatter between
// folds. A single parameter with an impossible sign is refused.
bool Examiner::impossible(const Hypothesis& h, const ColumnSet& own, const VectorXd& values,
                          const VectorXd& deviations) const {
  if (is_load(h)) return false;
  for (size_t k = 0; k < own.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    const double value = values[at];
    const double scale = std::max(data_.scale()[own[k]], numerics::kTiny);
    const double allowed = own.size() > 1 ? 2.0 * deviations[at] : 0.0;
    const bool negative = h.signs[k] == ParameterSign::kNonnegative && value < -allowed;
    const bool too_low = k < h.lowest.size() &&
                         value / scale < options_.thresholds.impossible_fall * h.lowest[k];
    if (negative || too_low) return true;
  }
  return false;
}

Evidence Examiner::evaluate(int h, const BaselineFit& before) const {
  Evidence e;
  e.hypothesis = h;
  const ColumnSet& own = columns_[h];
  e.collinear = own.empty();
  if (e.collinear) return e;
  const BorderedFit::Border whole = before.all->with(own);
  e.collinear = whole.new_share < options_.thresholds.new_share;
  if (e.collinear) return e;
  // The mean over folds and not the fall of the pooled error: one recording with a fault of its
  // own must not outvote the others.
  std::vector<double> falls;
  std::vector<double> own_falls;  // on the joint that it acts on: another one's noise must not outvote it
  const std::optional<JointIndex> joint = hypothesis(h).joint;
  MatrixXd without(whole.values.size(), static_cast<Eigen::Index>(before.folds.size()));
  for (size_t f = 0; f < before.folds.size(); ++f) {
    const BorderedFit::Border held_out = before.folds[f].with(own);
    const double d = log_fall(before.folds[f].residual2(), held_out.residual2);
    without.col(f) = held_out.values;
    e.gain += d / static_cast<double>(folds_.size());
    if (!acts_in(own, *folds_[f])) continue;
    falls.push_back(d);
    if (joint) {
      const Eigen::Index j = joint->value;
      own_falls.push_back(log_fall(before.folds[f].residual2().segment(j, 1),
                                   held_out.residual2.segment(j, 1)));
    }
  }
  e.infeasible_sign = impossible(hypothesis(h), own, whole.values, jackknife_deviations(without));
  const HoldOut how = hold_out(options_.thresholds);
  e.consistent = improve(falls, how) ||
                 (joint && (improve(own_falls, how) ||
                            signed_rank_p_value(own_falls) <= options_.thresholds.significance));
  e.stable =
      e.consistent || signed_rank_p_value(falls) <= options_.thresholds.significance;
  if (is_load(hypothesis(h)) && passes(e)) {
    e.infeasible_sign = compact_share(data_, hypothesis(h), before.set, before.weights) <
                    options_.thresholds.compact_load;
  }
  return e;
}

double Examiner::gain_of(const std::vector<int>& hypotheses, const BaselineFit& before) const {
  ColumnSet own;
  for (const int h : hypotheses) own.insert(own.end(), columns_[h].begin(), columns_[h].end());
  double sum = 0.0;
  for (const BorderedFit& fold : before.folds) sum += log_fall(fold.residual2(), fold.with(own).residual2);
  return sum / static_cast<double>(before.folds.size());
}

std::vector<BorderedFit> Examiner::without_clusters(const BaselineFit& before) const {
  std::vector<BorderedFit> out;
  out.reserve(data_.clusters());
  for (int c = 0; c < data_.clusters(); ++c)
    out.emplace_back(before.set, before.weights, data_.total(), &data_.cluster(c), nullptr);
  return out;
}

double Examiner::p_value(int h, const BaselineFit& before,
                         const std::vector<BorderedFit>& without_cluster) const {
  const ColumnSet& columns = columns_[h];
  if (columns.empty()) return 1.0;
  const VectorXd x = before.all->with(columns).values;
  MatrixXd solutions(x.size(), data_.clusters());
  for (int c = 0; c < data_.clusters(); ++c)
    solutions.col(c) = without_cluster[c].with(columns).values;
  const VectorXd std = jackknife_deviations(solutions);
  const Eigen::Index own = x.size();
  double best = 1.0;
  for (Eigen::Index k = 0; k < own; ++k) {
    best = std::min(best, student_t_two_sided(x[k] / std::max(std[k], numerics::kTiny),
                                              std::max(1, data_.clusters() - 1)));
  }
  best = std::min(1.0, best * static_cast<double>(own));
  if (own == 1 || 3 * own >= data_.clusters()) return best;
  return std::min(1.0, 2.0 * std::min(best, wald_p_value(x, solutions)));
}

const std::vector<Evidence>& Examiner::evaluate_all(const std::vector<int>& chosen) const {
  for (auto at = evaluated_.begin(); at != evaluated_.end();)  // of smaller selections, which are over
    at = at->first.size() + 1 < chosen.size() ? evaluated_.erase(at) : std::next(at);
  const auto [kept, is_new] = evaluated_.try_emplace(chosen, hypotheses_.size());
  std::vector<Evidence>& all = kept->second;
  if (!is_new) return all;
  const std::unique_ptr<BaselineFit> before = baseline(chosen);
  std::mutex told;
  int tested = 0;
  parallel_for(hypotheses(), options_.identification.threads, [&](int h) {
    if (options_.testing) {
      const std::lock_guard<std::mutex> lock(told);
      options_.testing(++tested, hypotheses());
    }
    Evidence& e = all[h];
    e.hypothesis = h;
    e.accepted = std::find(chosen.begin(), chosen.end(), h) != chosen.end();
    // A second constant of such a candidate would only bend the first one's curve.
    const Hypothesis& mine = hypothesis(h);
    e.collinear = !mine.repeats && !e.accepted &&
                 std::any_of(chosen.begin(), chosen.end(),
                             [&](int c) { return same_candidate(hypothesis(c), mine); });
    if (e.collinear) return;
    if (!e.accepted) e = evaluate(h, *before);
  });
  return all;
}

bool Examiner::passes(const Evidence& e) const {
  return stays(e) && e.consistent;
}

bool Examiner::stays(const Evidence& e) const {
  return !e.accepted && !e.collinear && !e.infeasible_sign && e.stable &&
         e.gain > options_.thresholds.smallest_gain;
}

VectorXd Examiner::prior(const std::vector<int>& chosen) const {
  VectorXd out = VectorXd::Zero(static_cast<Eigen::Index>(set_with(chosen).size()));
  auto at = static_cast<Eigen::Index>(base_.size());
  const NormalBlocks::Sums& all = data_.total();
  for (const int h : chosen) {
    const Hypothesis& one = hypotheses_[h];
    const auto own = static_cast<Eigen::Index>(columns_[h].size());
    if (own > 1 && one.joint && is_force_of_position(one)) {
      const int j = one.joint->value;
      const double torque2 = all.b2[j] / std::max(1.0, all.rows[j]);
      for (Eigen::Index k = 0; k < own; ++k)
        out[at + k] = 1.0 / std::max(torque2 * std::pow(data_.scale()[columns_[h][k]], 2), numerics::kTiny);
    }
    at += own;
  }
  return out;
}

VectorXd Examiner::deviations(const ColumnSet& set, const VectorXd& weights, double freedom, const VectorXd& prior) const {
  const auto rows = static_cast<Eigen::Index>(set.size());
  MatrixXd without(rows, data_.clusters());
  for (int c = 0; c < data_.clusters(); ++c)
    without.col(c) = data_.solve(set, weights, data_.total(), &data_.cluster(c), prior);
  const VectorXd of_clusters = jackknife_deviations(without);
  if (!several_recordings() || folds_.size() < 3) return of_clusters;
  without.resize(rows, static_cast<Eigen::Index>(folds_.size()));
  for (size_t f = 0; f < folds_.size(); ++f)
    without.col(f) =
        data_.solve(set, weights, data_.total(), folds_[f], prior);
  const double recordings = static_cast<double>(folds_.size()) - 1.0;
  const double wider = student_t_quantile(numerics::kOutside, recordings) /
                       student_t_quantile(numerics::kOutside, freedom);
  return of_clusters.cwiseMax(wider * jackknife_deviations(without));
}

}  // namespace veridyn
