#pragma once

#include <functional>
#include <string>
#include <vector>

#include "veridyn/control/cooperative_controller.hpp"
#include "veridyn/cooperation/scenario.hpp"
#include "veridyn/simulation/engine.hpp"

namespace veridyn {

/// One arm over time; (rows x n) or (rows x 3).
struct ArmTrace {
  MatrixXd q, dq, tau;
  MatrixXd tip;     ///< [m] in the world, true
  MatrixXd motion;  ///< x_d
  MatrixXd target;  ///< x_t
};

/// One member over time, (rows) each.
struct MemberTrace {
  VectorXd wanted;    ///< h_d [N]; 0 while it is let go
  VectorXd force;     ///< true tension [N]
  VectorXd measured;  ///< as the sensor says [N]
  VectorXd x_f;       ///< [m]
  VectorXd rate;      ///< dl/dt, true [m/s]; NaN on real boards, where nothing measures it
  VectorXd tracked;   ///< 1 where the member is held and its force is tracked
};

/// A held body over time, (rows x 3) each [m].
struct BodyTrace {
  MatrixXd position;  ///< Position of its centre in the world
  MatrixXd wanted;
};

/// What one member did in one phase.
struct MemberFigures {
  std::string member;
  double wanted = 0.0;         ///< [N] at the phase's end
  double largest_error = 0.0;  ///< [N] of the true force from h_d, at any time of the phase
  double rms_error = 0.0;      ///< [N]
  double steady_error = 0.0;   ///< [N] largest in the phase's last fifth
  double mean_error = 0.0;     ///< [N] mean there
  double overshoot = 0.0;      ///< [N] beyond the new h_d, where the phase changes it
  double oscillation = 0.0;    ///< [N] from least to largest force in the last fifth
  int corrections = 0;         ///< samples of the last fifth in which x_f changed
  double generated = 0.0;      ///< [J] see PassivityMonitor, after the phase's commands have ended;
                               ///< NaN where no rate is known
  bool tracked = false;        ///< all the time
};

struct PhaseFigures {
  std::string phase;
  double from = 0.0, to = 0.0;  ///< [s]
  std::vector<MemberFigures> members;
  double position_error = 0.0;        ///< [m] largest of the master's tip from x_d
  double final_position_error = 0.0;  ///< [m] at the end
  double body_error = 0.0;            ///< [m] largest of any held body from its way; 0: no bodies
  double asked_position_error = 0.0;  ///< [m] of the master's tip, or of the bodies; 0: none asked
  double asked_force_error = 0.0, asked_steady_error = 0.0;  ///< [N]; 0: nothing asked
  double duration = 0.0;   ///< [s] that the scenario gives it
  bool cut_short = false;  ///< ended before its time: then nothing counts as met

  double largest_force_error() const;   ///< [N] of the members tracked throughout; NaN: none
  double largest_steady_error() const;  ///< [N] likewise
  bool met() const;                     ///< all of it, within what was asked
};

/// What became of a scenario.
struct ScenarioRun {
  std::string name;
  std::string engine;
  std::vector<std::string> arms, members, bodies;
  std::vector<std::string> left_out;  ///< effects that the engine does not have
  VectorXd time;                      ///< (rows) [s]
  std::vector<ArmTrace> arm;
  std::vector<MemberTrace> member;  ///< members, then walls, whose forces push and are not tracked
  std::vector<BodyTrace> body;
  std::vector<PhaseFigures> phases;
  double largest_force = 0.0;  ///< [N] of any member at any time
  CooperativeState state = CooperativeState::kTracking;
  double held_at = 0.0;  ///< [s] where the state is not kTracking
  StepStatus status = StepStatus::kOk;
  double stopped_at = 0.0;  ///< [s] where the engine could not go on
  double seconds = 0.0;     ///< Seconds of computing

  double asked_largest_force = 0.0;  ///< [N]; 0: none asked

  bool complete() const { return status == StepStatus::kOk; }
  /// Complete, and every bound that the scenario asks for is met.
  bool met() const;
  std::string report() const;  ///< a table, for people
};

/// Runs it.
/// @param engine  see make_engine(). @param progress  told the share that is done; may be empty.
/// @throws InvalidInput  a model, a frame or a start that cannot be, as make_engine() and World.
ScenarioRun run_scenario(const Scenario& scenario, const std::string& engine = "veridyn",
                         const std::function<void(double)>& progress = {});

/// Rows as CSV: t, q1.., dq1.., tau1.. of all arms one after the other, then tips and forces by
/// name. Whole or not there.
void write_scenario_rows(const ScenarioRun& run, const std::string& path);
/// Its first line and row k, without their ends.
std::string scenario_row_names(const ScenarioRun& run);
std::string scenario_row(const ScenarioRun& run, Eigen::Index k);

}  // namespace veridyn
