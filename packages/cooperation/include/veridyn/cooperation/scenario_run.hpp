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
  MatrixXd tip;     ///< [m] true position in the world
  MatrixXd motion;  ///< [m] x_d: reference of the motion alone, see TipTarget
  MatrixXd target;  ///< [m] x_t: x_d with the correction of the force loops
};

/// One member over time, (rows) each.
struct MemberTrace {
  VectorXd wanted;    ///< h_d [N]; 0 while the member is released
  VectorXd force;     ///< true tension [N]
  VectorXd measured;  ///< [N] tension by the sensor
  VectorXd x_f;       ///< [m] correction of the force loop
  VectorXd rate;      ///< dl/dt, true [m/s]; NaN on real boards, where nothing measures it
  VectorXd tracked;   ///< 1 where the member is held and its force is tracked
  MatrixXd axes;      ///< (rows x 3) [N] measured force on the tip, in the world; empty unless a sensor has three axes
};

/// A held body over time, (rows x 3) each [m].
struct BodyTrace {
  MatrixXd position;  ///< [m] position of its centre in the world
  MatrixXd wanted;
};

/// Results of one member in one phase.
struct MemberFigures {
  std::string member;
  double wanted = 0.0;         ///< [N] h_d at the phase's end
  double largest_error = 0.0;  ///< [N] largest |true force - h_d| in the phase
  double rms_error = 0.0;      ///< [N] rms of force - h_d over the phase
  double steady_error = 0.0;   ///< [N] largest |force - h_d| in the phase's last fifth
  double mean_error = 0.0;     ///< [N] mean of force - h_d in the last fifth
  double overshoot = 0.0;      ///< [N] largest force beyond the new h_d if the phase changes h_d
  double oscillation = 0.0;    ///< [N] largest minus smallest force in the last fifth
  int corrections = 0;         ///< samples of the last fifth in which x_f changed
  double generated = 0.0;      ///< [J] see PassivityMonitor, after the phase's commands have ended;
                               ///< NaN if the rate is unknown
  bool tracked = false;        ///< true during the whole phase
};

struct PhaseFigures {
  std::string phase;
  double from = 0.0, to = 0.0;  ///< [s] begin and end of the phase
  std::vector<MemberFigures> members;
  double position_error = 0.0;        ///< [m] largest distance of the leader's tip from x_d
  double final_position_error = 0.0;  ///< [m] this distance at the end
  double body_error = 0.0;            ///< [m] largest distance of a held body from its path; 0: no bodies
  double asked_position_error = 0.0;  ///< [m] bound of the leader's tip, or of the bodies; 0: none
  double asked_force_error = 0.0, asked_steady_error = 0.0;  ///< [N] bounds; 0: none
  double duration = 0.0;   ///< [s] duration in the scenario
  bool cut_short = false;  ///< ended early: no bound counts as satisfied then

  double largest_force_error() const;   ///< [N] largest of the members tracked throughout; NaN: none
  double largest_steady_error() const;  ///< [N] likewise
  bool met() const;                     ///< true if all results are within their bounds
};

/// Result of a scenario.
struct ScenarioRun {
  std::string name;
  std::string engine;
  std::vector<std::string> arms, members, bodies;
  std::vector<std::string> left_out;  ///< effects that the engine does not support
  VectorXd time;                      ///< (rows) [s]
  std::vector<ArmTrace> arm;
  std::vector<MemberTrace> member;  ///< members, then walls, which push and are not tracked
  std::vector<BodyTrace> body;
  std::vector<PhaseFigures> phases;
  double largest_force = 0.0;  ///< [N] largest force of any member at any time
  CooperativeState state = CooperativeState::kTracking;
  double held_at = 0.0;  ///< [s] time at which targets were held, if the state is not kTracking
  StepStatus status = StepStatus::kOk;
  double stopped_at = 0.0;  ///< [s] time at which the engine failed
  double seconds = 0.0;     ///< computing time

  double asked_largest_force = 0.0;  ///< [N] bound; 0: none

  bool complete() const { return status == StepStatus::kOk; }
  /// True if the run is complete and within every bound of the scenario.
  bool met() const;
  std::string report() const;  ///< a table, for people
};

/// Runs a scenario. @param engine  see make_engine(). @param progress  called with the share done;
/// may be empty.
/// @throws InvalidInput  an invalid model, frame or start, as make_engine() and World.
ScenarioRun run_scenario(const Scenario& scenario, const std::string& engine = "veridyn",
                         const std::function<void(double)>& progress = {});

/// Writes rows as CSV, atomically: t, q1.., dq1.., tau1.. of all arms one after the other, then
/// tips and forces by name.
void write_scenario_rows(const ScenarioRun& run, const std::string& path);
/// The header of that file, without line end.
std::string scenario_row_names(const ScenarioRun& run);
/// Row k of that file, from 0, without line end.
std::string scenario_row(const ScenarioRun& run, Eigen::Index k);

}  // namespace veridyn
