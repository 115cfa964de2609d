#pragma once

#include <atomic>
#include <fstream>
#include <string>
#include <system_error>
#include <thread>

#include "veridyn/cooperation/scenario_run.hpp"

namespace veridyn::dvrk {

/// Writes the rows of a run to a file during the run, in a thread of ordinary priority, so that a
/// killed program leaves nearly all of them. The first line says that the file is incomplete;
/// write_scenario_rows() replaces it at the end. The file has a temporary name until it has a row, so that a
/// full disk keeps an existing one. Devices, pipes and unwritable files are left to write_scenario_rows().
class ScenarioRowFile {
 public:
  /// @param run  outlives this; its matrices stay where they are.
  ScenarioRowFile(const std::string& path, const ScenarioRun& run);
  ~ScenarioRowFile();
  ScenarioRowFile(const ScenarioRowFile&) = delete;
  ScenarioRowFile& operator=(const ScenarioRowFile&) = delete;

  /// Sets the number of rows that are complete. Neither waits nor allocates.
  void count(Eigen::Index rows) noexcept { rows_.store(rows, std::memory_order_release); }

 private:
  void follow();  ///< the thread: writes complete rows until the end

  const ScenarioRun& run_;
  std::string path_, aside_;
  bool named_ = false;
  std::error_code ignored_;  // error of renaming: a file that keeps its temporary name does not count as a recording
  std::ofstream file_;
  std::atomic<Eigen::Index> rows_{0};
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

}  // namespace veridyn::dvrk
