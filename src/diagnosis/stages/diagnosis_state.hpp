#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "diagnosis/causes/snags.hpp"
#include "diagnosis/evidence/numerics.hpp"
#include "diagnosis/shapes/candidate_data.hpp"
#include "identification/fold_errors.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn {

/// Normalises an entry of DiagnosisOptions::effects: a cause with the names of its joint or frame,
/// or the name of an effect. @throws InvalidInput  there is no such cause, or only a simulation
/// supports it.
std::string normalized_cause(const Model& arm, const std::string& words);

/// True for a cause that these words (normalized_cause()) name, alone or by its effect; empty: all.
bool is_among(const std::vector<std::string>& wanted, const Model& arm, const Cause& cause);

/// State of a diagnosis, passed from stage to stage. Every stage is a function of it, in its own
/// file; run_stages() in diagnosis.cpp defines their order.
struct DiagnosisState {
  Model arm;
  std::vector<std::string> train, test;
  DiagnosisOptions options;
  Diagnosis d;

  /// The baseline arm, with corrections and additions so far.
  Identification start;

  /// Findings of d that are contacts; they come first and are kept when the tests are repeated.
  size_t contacts = 0;
  std::vector<Snag> snags;

  /// Candidates that were refused after being applied to the arm.
  std::set<Candidate> refused;

  /// Findings whose effects are part of `start`, with the names of their parameters there: their
  /// values are those of the last fit. Indices of d.findings.
  std::map<size_t, std::vector<std::string>> fitted_by_start;

  /// Remarks on the recordings, which outlive another run of the questions.
  std::vector<std::string> remarks = {};

  /// Errors of single joints' channels (delays, gains) beyond their usual size that select_causes() accepted.
  std::vector<NotSupported> unusual = {};

  /// True while select_causes() refuses errors of single joints' channels beyond their usual size.
  bool usual_channels_only = false;

  /// Joints whose rows at the limit of their torque are left out.
  std::set<int> saturated = {};

  /// Joints without torque in all training recordings: nothing is asked about them.
  std::set<int> silent = {};

  /// Causes as text that are not asked about, whatever the options say.
  std::set<std::string> not_asked = {};

  /// Findings of d that are plain friction of a file without it; they follow the contacts.
  size_t plain_friction = 0;

  /// Names that may still be found: DiagnosisOptions::max_effects without those that d has. Contacts and plain friction
  /// do not count.
  int names_left() const;

  /// True if the effect is among those to test, at any place.
  bool tests_effect(const std::string& effect) const;

  /// True if the cause is among those to test, at its place.
  bool tests_cause(const Cause& cause) const;

  /// Fits an arm to the recordings, or evaluates it if its values are facts.
  Identification fit(const Model& any) const;

  /// Errors of such an arm on held-out parts of the training recordings: what decides between arms.
  FoldErrors fold_errors(const Identification& id) const;

  /// The list of questions that all stages begin with.
  CandidateList list() const;
};

/// Hypotheses of a list with the factors of their columns, without refused ones.
struct CandidateTests {
  CandidateData q;
  NormalBlocks data;
};
/// @param start  baseline of the tests; x.start unless a stage tries something.
CandidateTests prepare_tests(const DiagnosisState& x, const CandidateList& list, const Identification& start);

/// Sum over joints of ln(mean square) on the training recordings, on the rows that were fitted.
double log_training_error(const Identification& id);

/// Checks the quality of the recordings, and excludes channels that it finds faulty, and torques at their limits.
void check_quality(DiagnosisState& x);

/// Fits the arm of the file. False if the data do not suffice: d.baseline.status has the reason.
bool fit_baseline(DiagnosisState& x);

/// Excludes rests at either end of the training recordings, reports joints whose motions are
/// collinear, and fits the arm again if anything was excluded.
void exclude_rests(DiagnosisState& x);

/// Leaves out parts of recordings from now on.
void leave_out(const std::vector<ExcludedInterval>& parts, DiagnosisState& x);

/// Adds what is wrong with the signals of a recording or with the robot file to its quality, where the arm explains little:
/// see check_against(). The diagnosis goes on.
void ask_questions(DiagnosisState& x);

/// Leaves out the rows of joints without torque, and fits the arm again from the others. False if these do not determine
/// it: every joint's verdict says so.
bool leave_silent_joints_out(DiagnosisState& x);

/// Ends a diagnosis that asks nothing: every joint cannot_tell, for this reason.
void cannot_tell_of_all(DiagnosisState& x, const std::string& why);

/// Reports joints with significantly negative friction, which indicates a torque of the wrong sign.
void check_torque_signs(DiagnosisState& x);

/// Reports parameters that noise in the motion biases: the instrumental-variable estimate from
/// repeats of the motion differs from least squares.
void check_errors_in_variables(DiagnosisState& x);

/// Leaves out local friction of single recordings that an arm shows. True if any is new.
bool exclude_snags(const Identification& seen, DiagnosisState& x);

/// Leaves out contacts that an arm shows, and names them. True if there are any.
bool exclude_contacts(const Identification& seen, DiagnosisState& x);

/// Asks for viscous and Coulomb friction and an offset of all joints that have no friction in the
/// file, together.
void add_plain_friction(DiagnosisState& x);

/// Forgets all answers but contacts, and adds plain friction to x.start.
void begin_tests(DiagnosisState& x);

/// Corrects a wrong constant of the robot file, or the error of a channel that does as much.
void correct_constants(DiagnosisState& x);

/// Selects causes among all, corrects channels that come first, refines constants, weighs rivals,
/// and writes down what was found.
void select_causes(DiagnosisState& x);

/// Accounts for the residual of every joint, and for the signals on which it depends where no known
/// cause has that shape.
void account_for_errors(DiagnosisState& x);

/// After account_for_errors(), where joints have more than their floor or a name may stand for another (a force at each
/// position, a lean, a load): asks about causes that nobody asked about before and that act through positions, with
/// one in the arm about all others anew; compares all names with the description without any (plain friction and
/// curves); and asks anew without names that are doubted.
void test_names_together(DiagnosisState& x);

/// Marks what the held-out recordings contradict, orders by what matters.
void summarize(Diagnosis& d, const DiagnosisOptions& options);

}  // namespace veridyn
