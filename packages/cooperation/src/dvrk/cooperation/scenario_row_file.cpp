#include "scenario_row_file.hpp"

#include <unistd.h>

#include <chrono>
#include <filesystem>

#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

constexpr std::chrono::milliseconds kBetween{100};  // time between two checks for new rows

}  // namespace

ScenarioRowFile::ScenarioRowFile(const std::string& path, const ScenarioRun& run) : run_(run) {
  std::error_code& ignored = ignored_;
  if (std::filesystem::exists(path, ignored) && !std::filesystem::is_regular_file(path, ignored)) return;
  const bool linked = std::filesystem::is_symlink(path, ignored);  // the link is kept, and its target replaced
  path_ = linked ? std::filesystem::weakly_canonical(path, ignored).string() : path;
  aside_ = text(path_, ".part-", ::getpid());
  file_.open(aside_);
  if (!file_.good()) return;  // write_scenario_rows() reports the reason
  file_ << "# incomplete: the run had not ended when this was written\n" << scenario_row_names(run) << '\n';
  file_.flush();
  thread_ = std::thread([this] { follow(); });
}

ScenarioRowFile::~ScenarioRowFile() {
  ends_.store(true);
  if (!thread_.joinable()) return;
  thread_.join();
  file_.close();
  if (!named_) std::filesystem::remove(aside_, ignored_);
}

void ScenarioRowFile::follow() {
  for (Eigen::Index written = 0; !ends_.load();) {
    const Eigen::Index rows = rows_.load(std::memory_order_acquire);
    for (; written < rows; ++written) file_ << scenario_row(run_, written) << '\n';
    if (!file_.flush()) return;  // a full disk, which write_scenario_rows() reports
    if (!named_ && written > 0) {
      std::filesystem::rename(aside_, path_, ignored_);
      if (ignored_) return;
      named_ = true;
    }
    std::this_thread::sleep_for(kBetween);
  }
}

}  // namespace veridyn::dvrk
