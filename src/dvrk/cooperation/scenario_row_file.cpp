#include "scenario_row_file.hpp"

#include <chrono>
#include <filesystem>

namespace veridyn::dvrk {
namespace {

constexpr std::chrono::milliseconds kBetween{100};  // two looks for rows

}  // namespace

ScenarioRowFile::ScenarioRowFile(const std::string& path, const ScenarioRun& run) : run_(run) {
  std::error_code ignored;
  if (std::filesystem::exists(path, ignored) && !std::filesystem::is_regular_file(path, ignored)) return;
  file_.open(path);
  if (!file_.good()) return;  // write_scenario_rows() reports the reason
  file_ << "# incomplete: the run had not ended when this was written\n" << scenario_row_names(run) << '\n';
  file_.flush();
  thread_ = std::thread([this] { follow(); });
}

ScenarioRowFile::~ScenarioRowFile() {
  ends_.store(true);
  if (thread_.joinable()) thread_.join();
}

void ScenarioRowFile::follow() {
  for (Eigen::Index written = 0; !ends_.load();) {
    const Eigen::Index rows = rows_.load(std::memory_order_acquire);
    for (; written < rows; ++written) file_ << scenario_row(run_, written) << '\n';
    file_.flush();
    std::this_thread::sleep_for(kBetween);
  }
}

}  // namespace veridyn::dvrk
