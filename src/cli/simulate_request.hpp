#pragma once

#include <string>
#include <vector>

#include "commands.hpp"
#include "common_options.hpp"
#include "veridyn/simulation/breakaway.hpp"
#include "veridyn/simulation/simulate_controlled.hpp"

namespace veridyn::cli {

/// What `veridyn simulate` was asked.
struct SimulateRequest {
  std::string robot;
  std::string trajectory;
  std::string replay;
  std::string output;
  std::vector<std::string> effects;
  std::string noise = "low";
  std::string engine = "veridyn";
  std::string model_out;
  unsigned seed = 1;
  unsigned arm_seed = 1;
  std::string controller = "none";
  std::string drive = "commands";
  std::string breakaway;  // a joint
  std::string gains;
  std::vector<double> p, i, d, limit;
  LoopOptions loop;
  double set_point_cutoff = 3.5;  // [Hz]
  PreprocessingOptions preprocessing;
  CommonOptions common;
};

/// --controller, --gains, --replay and what belongs to them.
void add_control_options(CLI::App& command, SimulateRequest& request);

/// @throws CLI::ValidationError  options that do not go together.
void check_simulate_request(const SimulateRequest& request);

/// The recording and, if asked for, the true model.
void write_simulated(const SimulateRequest& request, const SimulatedRecording& simulated,
                     const std::string& remark);

std::string simulation_report(const SimulateRequest& request, const SimulatedRecording& simulated);

ExitStatus run_controlled(const SimulateRequest& request, const Model& arm,
                          const MotionSamples& wanted, const SimulationOptions& options);

ExitStatus run_replay(const SimulateRequest& request, const Model& arm);

ExitStatus run_breakaway(const SimulateRequest& request, const Model& arm);

}  // namespace veridyn::cli
