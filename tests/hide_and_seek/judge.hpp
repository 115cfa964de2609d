#pragma once

#include <string>
#include <vector>

#include "hide_and_seek/generator.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn::seek {

/// How well a diagnosis fits what was hidden.
struct Verdict {
  int hidden = 0;            ///< causes
  bool first = false;        ///< the first finding is one of them
  bool first_rival = false;  ///< the first finding is one, or names one among its rivals
  int named = 0;             ///< causes that a finding names
  int named_rival = 0;       ///< causes that a finding names or has among its rivals
  int named_loosely = 0;     ///< causes whose effect is named, on whatever joint or frame
  int extras = 0;            ///< findings that are none of the causes and no stand-in for one
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

/// What this tool names.
std::vector<NamedFinding> named_by(const Diagnosis& d);

Verdict judge(const HiddenCase& hidden, const Diagnosis& d);

/// The same for the findings of any tool; `error_ratio` stays 1.
/// @param also_true  what is no mistake to name, and was not asked for.
Verdict judge(const std::vector<Cause>& hidden, const std::vector<NamedFinding>& findings,
              const std::vector<Cause>& also_true = {});

/// What the tool starts from: the robot file, or in kChanged a MODEL of the clean arm.
Model known_arm(const HiddenCase& hidden, const CaseFiles& files, const std::string& folder,
                const IdentificationOptions& options);

/// Diagnoses the recordings of a case from there.
Diagnosis seek_causes(const HiddenCase& hidden, const CaseFiles& files, const std::string& folder,
                      const DiagnosisOptions& options);

}  // namespace veridyn::seek
