#include "diagnosis/evidence/examiner.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "diagnosis/causes/payload_fit.hpp"
#include "math/parallel.hpp"
#include "veridyn/math/student_t.hpp"

namespace veridyn {
namespace {

constexpr double kAbsorbed =
    1e-6;  // share of a column's square that must be new for the data to answer
// Share of what a payload's columns explain that a point mass must explain. Chosen on 40 simulated
// arms: 0.93 and more where there was a load, often below 0.6 where there was none.
constexpr double kCompact = 0.8;
constexpr double kImpossible = 1.2;  // a parameter may seem to fall by this share of itself

// Of the columns of a body those that the others do not span, first ones first.
ColumnSet independent(const NormalBlocks& data, const ColumnSet& all) {
  const auto k = static_cast<Eigen::Index>(all.size());
  MatrixXd S = MatrixXd::Zero(k, k);
  for (const JointSquares& G : data.total().G) {
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

// Of solutions without one cluster each.
VectorXd jackknife_deviations(const MatrixXd& solutions) {
  const auto g = static_cast<double>(solutions.cols());
  const VectorXd mean = solutions.rowwise().mean();
  return ((solutions.colwise() - mean).rowwise().squaredNorm() * ((g - 1.0) / g)).cwiseSqrt();
}

// All parameters together, by Hotelling's statistic: parameters that share one cause may each be
// uncertain while their sum is not.
double wald(const VectorXd& x, const MatrixXd& solutions) {
  const auto g = static_cast<double>(solutions.cols());
  const auto k = static_cast<double>(x.size());
  const MatrixXd centred = solutions.colwise() - solutions.rowwise().mean();
  MatrixXd S = centred * centred.transpose() * ((g - 1.0) / g);
  S.diagonal() *= 1.0 + 1e-9;
  const double T2 = x.dot(S.ldlt().solve(x));
  return fisher_f_upper_tail(T2 * (g - k) / (k * (g - 1.0)), k, g - k);
}

}  // namespace

ColumnSet columns_of(const NormalBlocks& data, const Hypothesis& hypothesis) {
  ColumnSet out;
  for (const std::string& name : hypothesis.columns) {
    for (int k = 0; k < data.columns(); ++k) {
      if (data.names()[static_cast<size_t>(k)] == name && data.scale()[k] > 0.0) out.push_back(k);
    }
  }
  return hypothesis.body >= 0 ? independent(data, out) : out;
}

Examiner::Examiner(const NormalBlocks& data, const ColumnSet& base,
                   const std::vector<Hypothesis>& hypotheses, const DiagnosisOptions& options)
    : data_(data), base_(base), hypotheses_(hypotheses), options_(options) {
  for (const auto& fold : make_folds(data)) folds_.push_back(summed(data, fold));
  std::set<std::string> families;
  for (const Hypothesis& h : hypotheses) {
    columns_.push_back(columns_of(data, h));
    families.insert(h.family);
  }
  families_ = static_cast<double>(std::max<size_t>(1, families.size()));
}

// One recording gives eight clusters only: the folds decide
// there, except for what one motion cannot show; the names are provisional.
double Examiner::limit(int h) const {
  const Hypothesis& hypothesis = hypotheses_[static_cast<size_t>(h)];
  const bool strict = several_recordings() || hypothesis.extrapolates;
  return options_.significance / ((strict ? families_ : 1.0) * hypothesis.tried);
}

ColumnSet Examiner::set_with(const std::vector<int>& chosen) const {
  ColumnSet set = base_;
  for (const int h : chosen)
    set.insert(set.end(), columns_[static_cast<size_t>(h)].begin(),
               columns_[static_cast<size_t>(h)].end());
  return set;
}

std::unique_ptr<Examiner::Stand> Examiner::stand(const std::vector<int>& chosen) const {
  auto out = std::make_unique<Stand>();
  out->set = set_with(chosen);
  out->weights = joint_weights(data_, out->set);
  out->all = std::make_unique<BorderedFit>(out->set, out->weights, data_.total(), nullptr, nullptr);
  out->folds.reserve(folds_.size());
  for (const auto& fold : folds_)
    out->folds.emplace_back(out->set, out->weights, data_.total(), &fold, &fold);
  return out;
}

bool Examiner::impossible(const Hypothesis& h, const ColumnSet& own, const VectorXd& values) const {
  for (size_t k = 0; k < own.size(); ++k) {
    const double value = values[static_cast<Eigen::Index>(k)];
    const double scale = std::max(data_.scale()[own[k]], 1e-300);
    const bool negative = h.body < 0 && h.signs[k] == ParameterSign::kNonnegative && value < 0.0;
    const bool absurd = std::abs(value) / scale > h.largest_value;
    const bool too_low = k < h.lowest.size() && value / scale < kImpossible * h.lowest[k];
    if (negative || absurd || too_low) return true;
  }
  return false;
}

Evidence Examiner::ask(int h, const Stand& before) const {
  Evidence e;
  e.hypothesis = h;
  const ColumnSet& own = columns_[static_cast<size_t>(h)];
  e.absorbed = own.empty();
  if (e.absorbed) return e;
  const BorderedFit::Border whole = before.all->with(own);
  e.absorbed = whole.new_share < kAbsorbed;
  if (e.absorbed) return e;
  e.sign_broken = impossible(hypothesis(h), own, whole.values);
  // The mean over folds and not the fall of the pooled error: one recording with a fault of its
  // own must not outvote the others.
  int better = 0;
  for (const BorderedFit& fold : before.folds) {
    const double d = log_fall(fold.residual2(), fold.with(own).residual2);
    e.gain += d / static_cast<double>(folds_.size());
    better += static_cast<int>(d > 0.0);
  }
  const auto folds = static_cast<double>(folds_.size());
  e.fold_share = static_cast<double>(better) / folds;
  // One fold of four or more may disagree: a recording can have a fault of its own.
  const double allowed = std::max(folds >= 4.0 ? 1.0 : 0.0, (1.0 - options_.fold_share) * folds);
  e.consistent = (1.0 - e.fold_share) * folds <= allowed + 1e-9;
  if (hypothesis(h).body >= 0 && passes(e)) {
    e.sign_broken = compact_share(data_, hypothesis(h), before.set, before.weights) < kCompact;
  }
  return e;
}

std::vector<BorderedFit> Examiner::without_clusters(const Stand& before) const {
  std::vector<BorderedFit> out;
  out.reserve(static_cast<size_t>(data_.clusters()));
  for (int c = 0; c < data_.clusters(); ++c)
    out.emplace_back(before.set, before.weights, data_.total(), &data_.cluster(c), nullptr);
  return out;
}

double Examiner::p_value(int h, const Stand& before,
                         const std::vector<BorderedFit>& left_out) const {
  const ColumnSet& columns = columns_[static_cast<size_t>(h)];
  if (columns.empty()) return 1.0;
  const VectorXd x = before.all->with(columns).values;
  MatrixXd solutions(x.size(), data_.clusters());
  for (int c = 0; c < data_.clusters(); ++c)
    solutions.col(c) = left_out[static_cast<size_t>(c)].with(columns).values;
  const VectorXd std = jackknife_deviations(solutions);
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

std::vector<Evidence> Examiner::ask_all(const std::vector<int>& chosen) const {
  const std::unique_ptr<Stand> before = stand(chosen);
  std::vector<Evidence> all(hypotheses_.size());
  parallel_for(hypotheses(), options_.identification.threads, [&](int h) {
    Evidence& e = all[static_cast<size_t>(h)];
    e.hypothesis = h;
    e.taken = std::find(chosen.begin(), chosen.end(), h) != chosen.end();
    if (!e.taken) e = ask(h, *before);
  });
  return all;
}

bool Examiner::passes(const Evidence& e) const {
  return !e.taken && !e.absorbed && !e.sign_broken && e.consistent &&
         e.gain > options_.smallest_gain;
}

VectorXd Examiner::deviations(const ColumnSet& set, const VectorXd& weights, double freedom) const {
  const auto rows = static_cast<Eigen::Index>(set.size());
  MatrixXd without(rows, data_.clusters());
  for (int c = 0; c < data_.clusters(); ++c)
    without.col(c) = data_.solve(set, weights, data_.total(), &data_.cluster(c));
  const VectorXd of_clusters = jackknife_deviations(without);
  if (!several_recordings() || folds_.size() < 3) return of_clusters;
  without.resize(rows, static_cast<Eigen::Index>(folds_.size()));
  for (size_t f = 0; f < folds_.size(); ++f)
    without.col(static_cast<Eigen::Index>(f)) =
        data_.solve(set, weights, data_.total(), &folds_[f]);
  const double recordings = static_cast<double>(folds_.size()) - 1.0;
  const double wider = student_t_quantile(0.05, recordings) / student_t_quantile(0.05, freedom);
  return of_clusters.cwiseMax(wider * jackknife_deviations(without));
}

}  // namespace veridyn
