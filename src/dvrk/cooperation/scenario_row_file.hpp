#pragma once

#include <atomic>
#include <fstream>
#include <string>
#include <thread>

#include "veridyn/cooperation/scenario_run.hpp"

namespace veridyn::dvrk {

/// The rows of a run as a file while they are made: a thread of ordinary priority follows them, so
/// that a program that is killed leaves all but its last moments. The first line says that the file
/// is incomplete; write_scenario_rows() replaces it when the run has ended. What is no regular file
/// or cannot be written is left to that.
class ScenarioRowFile {
 public:
  /// @param run  outlives this; its matrices stay where they are.
  ScenarioRowFile(const std::string& path, const ScenarioRun& run);
  ~ScenarioRowFile();
  ScenarioRowFile(const ScenarioRowFile&) = delete;
  ScenarioRowFile& operator=(const ScenarioRowFile&) = delete;

  /// So many rows are there now. Neither waits nor allocates.
  void count(Eigen::Index rows) noexcept { rows_.store(rows, std::memory_order_release); }

 private:
  void follow();

  const ScenarioRun& run_;
  std::ofstream file_;
  std::atomic<Eigen::Index> rows_{0};
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

}  // namespace veridyn::dvrk
