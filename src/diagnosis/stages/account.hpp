#pragma once

#include <string>
#include <vector>

#include "diagnosis/stages/diagnosis_state.hpp"
#include "diagnosis/unnamed/dependence.hpp"
#include "diagnosis/unnamed/motion_signals.hpp"

namespace veridyn {

/// What the extended model leaves over on held-out parts of the training recordings, and how much of it curves predict.
struct UnexplainedError {
  VectorXd folds;               ///< (n) relative error there
  std::vector<double> unnamed;  ///< (n) share of its square that findings without a name predict
  std::vector<MotionSignal> signals;
};

/// An error with so much of its mean square predicted.
double without_share(double error, double share);

/// True if held-out parts of the training recordings show a dependence, and enough of it.
bool is_clear(const Dependence& found, const DiagnosisState& x);

/// Held-out error of a joint, from 0; without rows at the limit of its torque, which no model of the arm predicts.
/// NaN where nothing is held out.
double held_out_error(const DiagnosisState& x, const Identification& id, int joint);

/// "q1 and dq2"
std::string signal_words(const std::vector<std::string>& signals);

/// Withdraws names on joints with more than their floor: those small beside an unnamed dependence, which
/// biases them, and those without which smooth functions of signals that the effect does not act through
/// predict the held-out parts as well (an encompassing test, Mizon and Richard 1986). Joints that move as
/// one and a single recording leave open which signal it is.
/// @returns true if there were any: the extended model is fitted without them, and has no account.
bool withdraw_names(DiagnosisState& x, const UnexplainedError& left);

/// Withdraws names that held-out parts contradict, beside a dependence that has none or where no error is left to name.
void withdraw_contradicted(DiagnosisState& x);

/// Keeps findings without a name as tables of the extended model. A joint that it predicts worse gets none.
void keep_tables(DiagnosisState& x, const UnexplainedError& left);

}  // namespace veridyn
