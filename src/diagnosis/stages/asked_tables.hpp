#pragma once

#include <vector>

#include "diagnosis/stages/diagnosis_state.hpp"
#include "diagnosis/unnamed/motion_signals.hpp"

namespace veridyn {

/// A table that the recordings accept beside all parameters of the arm, which were free.
struct AcceptedTable {
  JointIndex joint;
  EffectTerm term;      ///< without values
  UnnamedShape shape;   ///< its nodes
  double gain = 0.0;
  double p_value = 1.0;
};

/// Asks, as of any cause, for tables of single signals on some joints: positions of all joints, own
/// velocity and load. What a regression of the residual cannot see because other parameters took it
/// up shows here.
std::vector<AcceptedTable> ask_tables(const DiagnosisState& x, const std::vector<MotionSignal>& signals,
                                      const std::vector<int>& joints);

}  // namespace veridyn
