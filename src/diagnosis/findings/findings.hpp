#pragma once

#include <set>
#include <string>
#include <vector>

#include "diagnosis/shapes/candidate_data.hpp"
#include "diagnosis/shapes/refinement.hpp"
#include "veridyn/diagnosis/payload.hpp"

namespace veridyn {

/// Turns a selection into findings: values, intervals, sentences, held-out errors.
class FindingWriter {
 public:
  /// @param asked  all hypotheses, with the factors of their columns and the selection. @param fit
  /// the accepted ones. @param start  baseline of the tests: its held-out errors are the first
  /// "before".
  FindingWriter(const CandidateData& asked, const NormalBlocks& asked_data, const Selection& selection,
                const Fit& fit, const Identification& start, bool changes,
                const DiagnosisOptions& limits);

  /// The findings in order of discovery, appended to d.findings. Several constants of one effect on
  /// one axis (memories of different lengths, waves of different orders) are one finding.
  void add_findings(Diagnosis& d) const;

  /// Names of the parameters of every finding that add_findings() writes, as the extended arm has
  /// them.
  std::vector<std::vector<std::string>> parameter_names() const;

  /// For every finding of add_findings() whether it is another constant of an effect of the model,
  /// and no cause.
  std::vector<char> own_constants() const;

  /// Fits the k-th finding, a load, anew beside no change of friction, which the extended arm does not have;
  /// writes it into `f`. False if it is no load.
  bool fit_load_alone(size_t k, Finding& f);

  /// Adds one line for every candidate that was tested and not accepted.
  void add_the_rest(Diagnosis& d) const;

  /// The arm with all that was found; what needs fitting has no values yet.
  Model extended_arm() const;

  /// The same with a subset of the findings of add_findings().
  Model extended_arm(const std::set<size_t>& kept) const;

 private:
  using Group = std::vector<size_t>;  // accepted hypotheses that are one finding
  std::vector<Group> groups() const;
  // Errors of the arms that grow by one finding at a time.
  struct Step {
    VectorXd test, folds;
  };
  Finding finding(const Group& group, const Step& before, const Step& after) const;
  Model extended_arm_of(const std::vector<size_t>& chosen) const;
  std::vector<FoundParameter> parameters_of(const Hypothesis& h) const;
  double own_deviation(const Hypothesis& h, const std::string& parameter) const;
  std::vector<double> values_of(const Hypothesis& h) const;
  std::string phrase_of(const Hypothesis& h) const;
  std::vector<FoundParameter> payload_parameters(const Hypothesis& h) const;
  std::string phrase_of(const Group& group, const Finding& f) const;
  std::string change_text(const Hypothesis& h, const Finding& f) const;
  std::vector<Step> errors_along_the_way() const;
  VectorXd fold_error(const ColumnSet& set, const VectorXd& w) const;
  const Hypothesis& accepted(size_t k) const;
  const Hypothesis& asked_hypothesis(const Hypothesis& h) const;
  const CandidateData& asked_;
  const NormalBlocks& asked_data_;
  const Selection& selection_;
  const Fit& fit_;
  const CandidateData& q_;  ///< The columns of the fit
  const NormalBlocks& data_;
  const Identification& start_;
  bool changes_;
  const DiagnosisOptions& limits_;
  std::vector<PayloadEstimate> payloads_;  ///< one for each accepted; without frame if it is none
};

}  // namespace veridyn
