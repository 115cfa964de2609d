#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "diagnosis/causes/snags.hpp"
#include "diagnosis/numerics.hpp"
#include "diagnosis/shapes/inquiry.hpp"
#include "identification/fold_errors.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn {

/// One of DiagnosisOptions::effects with the names of its joint or frame; the name of an effect as
/// it is. @throws InvalidInput  there is no such cause, or only a simulation knows it.
std::string asked_cause(const Model& arm, const std::string& words);

/// What the stages of a diagnosis hand from one to the next. Every stage is a function of it, in
/// its own file; run_stages() in diagnosis.cpp says their order.
struct Investigation {
  Model arm;
  std::vector<std::string> train, test;
  DiagnosisOptions options;
  Diagnosis d;

  /// The arm that questions are asked about, with what is already corrected or added.
  Identification start;

  /// Findings of d that are contacts; they stand first and outlive another run of the questions.
  size_t contacts = 0;
  std::vector<Snag> snags;

  /// Families of hypotheses that the recordings refused once they were applied to the arm.
  std::set<std::string> refused;

  /// Findings whose effects are part of `start`, with the names of their parameters there: their
  /// values are those of the last fit. Indices of d.findings.
  std::map<size_t, std::vector<std::string>> fitted_by_start;

  /// Remarks on the recordings, which outlive another run of the questions.
  std::vector<std::string> remarks = {};

  /// True if the effect is one of those asked for, at whatever place.
  bool asks_for(const std::string& effect) const;

  /// True if the cause is asked for, at its place.
  bool asks_about(const Cause& cause) const;

  /// An arm on the recordings: identified, or as it stands if its values are facts.
  Identification look(const Model& any) const;

  /// Errors of such an arm on held-out parts of the training recordings: what decides between arms.
  FoldErrors fold_errors(const Identification& id) const;

  /// The list of questions that all stages begin with.
  QuestionList list() const;
};

/// Hypotheses of a list with the factors of their columns, without refused families.
struct Questions {
  Inquiry q;
  NormalBlocks data;
};
/// @param start  what the questions stand on; x.start unless a stage tries something.
Questions ask(const Investigation& x, const QuestionList& list, const Identification& start);

/// Sum over joints of ln(mean square) on the training recordings, on the rows that were fitted.
double log_training_error(const Identification& id);

/// Quality of the recordings; channels that they cannot trust.
void check_quality(Investigation& x);

/// The arm as the file says. False if the data cannot answer: d.baseline.status says why.
bool fit_baseline(Investigation& x);

/// Leaves out the rests at either end of the training recordings, says of the joints that move as
/// one that they do, and fits the arm again where anything was left out.
void exclude_rests(Investigation& x);

/// Leaves out parts of recordings from now on.
void leave_out(const std::vector<LeftOut>& parts, Investigation& x);

/// Reports joints whose friction comes out negative beyond doubt: a torque with the wrong sign.
void check_torque_signs(Investigation& x);

/// Reports parameters that noise in the motion biases: the instrumental-variable estimate from
/// repeats of the motion differs from least squares.
void check_errors_in_variables(Investigation& x);

/// Leaves out local friction of single recordings that an arm shows. True if any is new.
bool exclude_snags(const Identification& seen, Investigation& x);

/// Leaves out contacts that an arm shows, and names them. True if there are any.
bool exclude_contacts(const Identification& seen, Investigation& x);

/// Asks for viscous and Coulomb friction and an offset of all joints that have no friction in the
/// file, together.
void add_plain_friction(Investigation& x);

/// Corrects a wrong constant of the robot file, or the error of a channel that does as much.
void correct_constants(Investigation& x);

/// Selects causes among all, corrects channels that come first, refines constants, weighs rivals,
/// and writes down what was found.
void select_causes(Investigation& x);

/// Says of every joint what is left over, and of which signals it is a function where no cause of
/// the list has that shape.
void account_for_errors(Investigation& x);

/// Marks what the held-out recordings contradict, orders by what matters.
void summarize(Diagnosis& d, const Thresholds& thresholds);

}  // namespace veridyn
