#pragma once

#include <string>
#include <vector>

#include "hide_and_seek/generator.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn::seek {

/// Comparison of a diagnosis with the hidden causes.
struct Verdict {
  int hidden = 0;            ///< causes
  bool first = false;        ///< the first finding is one of them
  bool first_rival = false;  ///< the first finding is one, or names one among its rivals
  int named = 0;             ///< causes that a finding names
  int named_rival = 0;       ///< causes that a finding names or has among its rivals
  int named_loosely = 0;     ///< causes whose effect is named, on whatever joint or frame
  int extras = 0;            ///< findings that neither are a hidden cause nor have one as rival
  int intervals = 0;         ///< parameters of right findings whose truth is known
  int covered = 0;           ///< of these, inside the 95 % interval
  double error_ratio = 1.0;  ///< held-out error after / before, at the joint of the first cause
  std::string outside;       ///< parameters that are not covered: name, truth and interval
};

/// A cause as some tool names it.
struct Named {
  std::string effect;
  int joint = 0;      ///< from 1; 0: the whole arm
  std::string frame;  ///< of a load or a wrong constant
  std::string why;    ///< of a rival
};

struct NamedFinding : Named {
  std::vector<FoundParameter> parameters;
  std::vector<Named> rivals;
};

/// The findings of a diagnosis.
std::vector<NamedFinding> named_by(const Diagnosis& d);

Verdict judge(const HiddenCase& hidden, const Diagnosis& d);

/// The same for the findings of any tool; `error_ratio` stays 1.
/// @param also_true  further true causes, which do not count as extras.
Verdict judge(const std::vector<Cause>& hidden, const std::vector<NamedFinding>& findings,
              const std::vector<Cause>& also_true = {});

/// The robot file, or in kChanged a MODEL of the arm without the causes.
Model known_arm(const HiddenCase& hidden, const CaseFiles& files, const std::string& folder,
                const IdentificationOptions& options);

/// Diagnoses the recordings of a case from there.
Diagnosis seek_causes(const HiddenCase& hidden, const CaseFiles& files, const std::string& folder,
                      const DiagnosisOptions& options);

}  // namespace veridyn::seek
