#pragma once

#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "veridyn/tool/common_options.hpp"
#include "veridyn/simulation/breakaway.hpp"
#include "veridyn/simulation/simulate_controlled.hpp"

namespace veridyn::cli {

/// Options of `veridyn simulate`.
struct SimulateRequest {
  const CLI::App* command = nullptr;  // the command whose options were given
  std::string robot;
  std::string trajectory;
  std::string replay;
  std::string output;
  std::vector<std::string> effects;
  std::string noise = "low";
  double sample_rate = 0.0;  // [Hz] rate of the recording; 0: that of the trajectory
  std::string engine = "veridyn";
  std::string model_out;
  unsigned seed = 1;
  unsigned arm_seed = 1;
  std::string controller = "none";
  std::string drive = "commands";
  std::string breakaway;         // name or number of a joint; empty: none
  double breakaway_speed = 0.0;  // [rad/s], [m/s] speed of sliding; 0: default
  std::string gains;
  std::vector<double> p, i, d, limit;
  std::vector<double> steps;     // [rad], [m] steps of one joint after the other, in place of a trajectory
  std::string controller_model;  // model of computed torque; empty: the arm as in its file
  LoopOptions loop;
  double set_point_cutoff = 0.0;  // [Hz]; 0: none
  PreprocessingOptions preprocessing;
  CommonOptions common;
};

/// Adds --controller, --gains, --replay and their options.
void add_control_options(CLI::App& command, SimulateRequest& request);

/// @throws CLI::ValidationError  options that exclude each other.
void check_simulate_request(const SimulateRequest& request);

/// Writes the recording and, on request, the true model.
void write_simulated(const SimulateRequest& request, const SimulatedRecording& simulated);

std::string simulation_report(const SimulateRequest& request, const SimulatedRecording& simulated);

/// The control loop that the options describe; its gains are empty if neither an option nor a file gives them.
LoopOptions control_loop_options(const SimulateRequest& request, const Model& arm);

Recording rows_of(const MotionSamples& motion, const MatrixXd& tau);

/// Reports the effects that an engine does not support.
void report_omitted_effects(const SimulateRequest& request, const std::vector<std::string>& left_out);

/// Reports a run that stopped early; its results are not written.
bool stopped(const EngineRun& run, const Model& arm);

/// @param command_line  command line that the page shows.
ExitStatus run_controlled(const SimulateRequest& request, const Model& arm,
                          const MotionSamples& wanted, const SimulationOptions& options,
                          const std::string& command_line);

ExitStatus run_replay(const SimulateRequest& request, const Model& arm,
                      const std::string& command_line);

ExitStatus run_breakaway(const SimulateRequest& request, const Model& arm,
                         const std::string& command_line);

}  // namespace veridyn::cli
