#pragma once

#include <deque>
#include <map>
#include <memory>
#include <vector>

#include "diagnosis/evidence/bordered_fit.hpp"
#include "diagnosis/evidence/folds.hpp"
#include "diagnosis/evidence/hypotheses.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn {

/// Evidence of the data for one hypothesis beside those already accepted.
struct Evidence {
  int hypothesis = 0;
  double gain = 0.0;        ///< d: fall of the sum over joints of ln(held-out mean square error)
  bool consistent = false;  ///< the folds improve, of four or more all but one
  bool stable = false;     ///< they do, or by their signed ranks they do beyond chance
  double p_value = 1.0;
  bool accepted = false;     ///< it is accepted already
  bool collinear = false;  ///< its columns lie in the span of the others: these data cannot answer
  bool infeasible_sign = false;  ///< a parameter significantly has an impossible sign
};

/// Column indices of a hypothesis; those of a body that the others do not span.
ColumnSet columns_of(const NormalBlocks& data, const Hypothesis& hypothesis);

/// Tests hypotheses one at a time, each in the presence of a set of accepted ones.
class Examiner {
 public:
  /// @param data, hypotheses  must outlive the examiner.
  /// @param base  columns that are always there (independent ones).
  Examiner(const NormalBlocks& data, const ColumnSet& base,
           const std::vector<Hypothesis>& hypotheses, const DiagnosisOptions& options);

  /// The chosen columns, factored on all rows and on the rows outside of every fold.
  struct BaselineFit {
    ColumnSet set;
    VectorXd weights;
    std::unique_ptr<BorderedFit> all;
    std::vector<BorderedFit> folds;
  };
  std::unique_ptr<BaselineFit> baseline(const std::vector<int>& chosen) const;

  /// Evaluates a hypothesis, without the Wald test.
  Evidence evaluate(int hypothesis, const BaselineFit& before) const;

  /// Evidence::gain of several hypotheses together.
  double gain_of(const std::vector<int>& hypotheses, const BaselineFit& before) const;

  /// evaluate() for every hypothesis that is not chosen, beside the chosen ones. Answers are kept: a selection asks the
  /// same again when it looks for a swap, for one more and for rivals. The reference holds until the next call.
  const std::vector<Evidence>& evaluate_all(const std::vector<int>& chosen) const;

  /// True if the evidence suffices for acceptance.
  bool passes(const Evidence& e) const;

  /// True if an accepted hypothesis may stay beside those accepted later: with weaker conditions
  /// than for acceptance, because causes that share a torque would otherwise displace each other.
  bool stays(const Evidence& e) const;

  /// The chosen columns on the rows outside of every cluster, for p_value().
  std::vector<BorderedFit> without_clusters(const BaselineFit& before) const;
  double p_value(int hypothesis, const BaselineFit& before,
                 const std::vector<BorderedFit>& without_cluster) const;

  /// The largest p value that counts.
  double limit(int hypothesis) const;

  /// Base and chosen columns.
  ColumnSet set_with(const std::vector<int>& chosen) const;

  /// Standard deviations of a fit, (set): the larger of two jackknifes, over clusters, and over
  /// whole recordings where there are several, for what is systematic to one motion shows only
  /// there. Scaled for a t distribution with `freedom`.
  VectorXd deviations(const ColumnSet& set, const VectorXd& weights, double freedom,
                      const VectorXd& prior = {}) const;

  /// Precisions of a normal prior for NormalBlocks::solve() over set_with(chosen): the terms of a smooth force of
  /// position are each of the size of their joint's rms torque. What gravity does as well is thereby left to gravity,
  /// and terms that cancel against it stay small. Zero for all other columns.
  VectorXd prior(const std::vector<int>& chosen) const;

  const NormalBlocks& data() const { return data_; }
  const Hypothesis& hypothesis(int h) const { return hypotheses_[h]; }
  int hypotheses() const { return static_cast<int>(hypotheses_.size()); }

 private:
  bool several_recordings() const { return data_.recording_of(data_.clusters() - 1) > 0; }
  bool impossible(const Hypothesis& h, const ColumnSet& own, const VectorXd& values,
                  const VectorXd& deviations) const;

  const NormalBlocks& data_;
  ColumnSet base_;
  const std::vector<Hypothesis>& hypotheses_;
  DiagnosisOptions options_;
  std::deque<NormalBlocks::Sums> sums_;           // of folds of several clusters
  std::vector<const NormalBlocks::Sums*> folds_;
  std::vector<ColumnSet> columns_;
  double asked_ = 1.0;  // candidates
  mutable std::map<std::vector<int>, std::vector<Evidence>> evaluated_;  // by what is chosen
};

}  // namespace veridyn
