#pragma once

#include <set>
#include <string>
#include <vector>

#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn {

/// Normalises an entry of DiagnosisOptions::effects: a cause with the names of its joint or frame, or the
/// name of an effect.
/// @throws InvalidInput  the cause does not exist, or can only be simulated.
std::string normalized_cause(const Model& arm, const std::string& words);

/// True if `wanted` (see normalized_cause()) is empty or contains the cause or its effect.
bool is_among(const std::vector<std::string>& wanted, const Model& arm, const Cause& cause);

/// State of a diagnosis, passed from step to step; diagnosis.cpp defines their order.
struct DiagnosisState {
  Model arm;
  std::vector<std::string> train, test;
  DiagnosisOptions options;
  Diagnosis d;
  bool poses = false;  ///< the recordings are poses at rest

  /// The arm with which the search begins, fitted to the rows that remain.
  Identification start = {};

  /// Remarks on the recordings.
  std::vector<std::string> remarks = {};

  /// Joints with rows at the torque limit; these rows are excluded.
  std::set<int> saturated = {};

  /// Joints without torque in all training recordings: no cause on them is tested.
  std::set<int> silent = {};

  /// True if the effect is among those to test, at any place.
  bool tests_effect(const std::string& effect) const;

  /// True if the cause is among those to test, at its place.
  bool tests_cause(const Cause& cause) const;

  /// Fits an arm to the recordings, or evaluates it if its values are facts.
  Identification fit(const Model& any) const;
};

/// Checks the quality of the recordings, and excludes channels that it finds faulty, and torques at their limits.
void check_quality(DiagnosisState& x);

/// Fits the arm of the file. False if the data do not suffice: d.baseline.status has the reason.
bool fit_baseline(DiagnosisState& x);

/// Excludes rests at either end of the training recordings, reports joints whose motions are
/// collinear, and fits the arm again if anything was excluded.
void exclude_rests(DiagnosisState& x);

/// False, with a reason in every joint's verdict, if errors cannot be attributed to joints: the training
/// motions are collinear, or the torques do not follow from the arm's motion at all.
bool can_attribute_errors(DiagnosisState& x);

/// Excludes parts of recordings from all later steps.
void leave_out(const std::vector<ExcludedInterval>& parts, DiagnosisState& x);

/// Excludes the rows of joints without torque and fits the arm again. False, with a reason in every joint's
/// verdict, if the remaining rows do not determine the arm.
bool exclude_silent_joints(DiagnosisState& x);

/// Ends the diagnosis without any test: every joint is cannot_tell, for this reason.
void end_without_verdicts(DiagnosisState& x, const std::string& why);

/// Reports joints with significantly negative friction, which suggests a torque of the wrong sign.
void check_torque_signs(DiagnosisState& x);

/// Reports parameters that are biased by noise in the motion: the instrumental-variable estimate from repeats
/// of the motion differs from that of least squares.
void check_errors_in_variables(DiagnosisState& x);

}  // namespace veridyn
