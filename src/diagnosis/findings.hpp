#pragma once

#include <vector>

#include "diagnosis/shapes/inquiry.hpp"
#include "diagnosis/shapes/refinement.hpp"
#include "veridyn/diagnosis/payload.hpp"

namespace veridyn {

/// What a selection found, ready to be named: values, intervals, sentences, held-out errors.
class FindingWriter {
 public:
  /// @param asked  all hypotheses, with the factors of their columns and what was selected.
  /// @param fit    the accepted ones.
  /// @param start  what the questions stand on: its held-out errors are the first "before".
  FindingWriter(const Inquiry& asked, const NormalBlocks& asked_data, const Selection& selection,
                const Fit& fit, const Identification& start, bool changes,
                const DiagnosisOptions& limits);

  /// The findings in order of discovery, appended to d.findings.
  void add_findings(Diagnosis& d) const;

  /// One line for every family that was asked and not accepted.
  void add_the_rest(Diagnosis& d) const;

  /// Adds the values of the one accepted hypothesis, a further step of the same one, to a finding.
  void add_step(Finding& f) const;

  /// The arm with all that was found; what needs fitting has no values yet.
  Model extended_arm() const;

 private:
  Finding finding(size_t accepted, const VectorXd& before, const VectorXd& after) const;
  std::vector<FoundParameter> parameters_of(const Hypothesis& h) const;
  double own_deviation(const Hypothesis& h, const std::string& parameter) const;
  std::vector<double> values_of(const Hypothesis& h) const;
  std::vector<FoundParameter> payload_parameters(const Hypothesis& h) const;
  std::string sentence(const Hypothesis& h, const Finding& f) const;
  std::string change_text(const Hypothesis& h, const Finding& f) const;
  std::vector<VectorXd> errors_along_the_way() const;
  const Hypothesis& accepted(size_t k) const;
  const Hypothesis& asked_hypothesis(const Hypothesis& h) const;
  Rival rival(const Hypothesis& h, const std::string& why) const;

  const Inquiry& asked_;
  const NormalBlocks& asked_data_;
  const Selection& selection_;
  const Fit& fit_;
  const Inquiry& q_;  ///< of the fit
  const NormalBlocks& data_;
  const Identification& start_;
  bool changes_;
  const DiagnosisOptions& limits_;
  std::vector<PayloadEstimate> payloads_;  ///< one for each accepted; without frame if it is none
};

}  // namespace veridyn
