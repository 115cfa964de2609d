#pragma once

#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "cli/options/common_options.hpp"
#include "veridyn/simulation/breakaway.hpp"
#include "veridyn/simulation/simulate_controlled.hpp"

namespace veridyn::cli {

/// What `veridyn simulate` was asked.
struct SimulateRequest {
  const CLI::App* command = nullptr;  // the command whose options were given
  std::string robot;
  std::string trajectory;
  std::string replay;
  std::string output;
  std::vector<std::string> effects;
  std::string noise = "low";
  double sample_rate = 0.0;  // [Hz]; 0: that of the trajectory
  std::string engine = "veridyn";
  std::string model_out;
  unsigned seed = 1;
  unsigned arm_seed = 1;
  std::string controller = "none";
  std::string drive = "commands";
  std::string breakaway;         // a joint
  double breakaway_speed = 0.0;  // [rad/s], [m/s]; 0: the usual
  std::string gains;
  std::vector<double> p, i, d, limit;
  LoopOptions loop;
  double set_point_cutoff = 0.0;  // [Hz]; 0: none
  PreprocessingOptions preprocessing;
  CommonOptions common;
};

/// --controller, --gains, --replay and what belongs to them.
void add_control_options(CLI::App& command, SimulateRequest& request);

/// @throws CLI::ValidationError  options that do not go together.
void check_simulate_request(const SimulateRequest& request);

/// The recording and, if asked for, the true model.
void write_simulated(const SimulateRequest& request, const SimulatedRecording& simulated);

std::string simulation_report(const SimulateRequest& request, const SimulatedRecording& simulated);

/// The loop that was asked for. Without gains in words or in a file it has none.
LoopOptions loop_of(const SimulateRequest& request, const Model& arm);

Recording rows_of(const MotionSamples& motion, const MatrixXd& tau);

/// Tells the user which effects an engine does not have.
void tell_left_out(const SimulateRequest& request, const std::vector<std::string>& left_out);

/// Tells the user where a run stopped early; nothing of it is written then.
bool stopped(const EngineRun& run, const Model& arm);

/// @param command_line  of the run, for its page.
ExitStatus run_controlled(const SimulateRequest& request, const Model& arm,
                          const MotionSamples& wanted, const SimulationOptions& options,
                          const std::string& command_line);

ExitStatus run_replay(const SimulateRequest& request, const Model& arm,
                      const std::string& command_line);

ExitStatus run_breakaway(const SimulateRequest& request, const Model& arm,
                         const std::string& command_line);

}  // namespace veridyn::cli
