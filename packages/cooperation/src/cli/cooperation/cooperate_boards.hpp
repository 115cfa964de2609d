#pragma once

#include <memory>
#include <string>
#include <vector>

#include "veridyn/tool/program.hpp"
#include "veridyn/tool/common_options.hpp"
#include "veridyn/cooperation/live.hpp"

namespace veridyn::cli {

/// Options of `cooperate --boards`.
struct BoardsRequest {
  std::vector<std::string> configs;       ///< XML or JSON, or names of known arms, one per arm
  std::vector<std::string> hosts;         ///< HOST[:PORT], one per arm
  std::vector<std::string> sensors;       ///< force sources, one per member
  std::vector<std::string> calibrations;  ///< files, one per member
  std::vector<std::string> faults;        ///< see parse_emulated_fault()
  bool emulate = false, stepped = false, unrehearsed = false;
};

/// Options of `cooperate --live`, with or without boards.
struct LiveRequest {
  std::string line;  ///< "-" or "udp:..."; empty: the scenario's phases
  double pace = 1.0, silence = 0.5;
};
/// Opens the source of lines; a usage error of --live if it cannot be opened.
std::unique_ptr<LineSource> open_line(const LiveRequest& request);
LiveOptions live_options(const LiveRequest& request);
LiveReport printing_live_report();  ///< prints states to standard output, refused lines as messages

void add_boards_options(CLI::App& command, BoardsRequest& request);

/// Runs the scenario, or live commands, on boards and writes the requested files.
ExitStatus run_boards(const BoardsRequest& request, const LiveRequest& live, const Scenario& scenario,
                      const std::string& path, const CommonOptions& common,
                      const std::string& output, const std::string& command_line);

}  // namespace veridyn::cli
