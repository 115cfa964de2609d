#include "hide_and_seek/journal.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>

#include "hide_and_seek/board.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::seek {
namespace {

class AJournal : public testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove(path_); }
  const std::string path_ = testing::TempDir() + "veridyn-journal-" + std::to_string(::getpid());
};

long size_of(const std::string& path) {
  std::error_code missing;
  const auto size = std::filesystem::file_size(path, missing);
  return missing ? 0 : static_cast<long>(size);
}

TEST_F(AJournal, ContainsEverythingWrittenBeforeAKill) {
  int held = 0;
  for (int kill = 0; kill < 8; ++kill) {
    const long before = size_of(path_);
    const pid_t child = ::fork();
    if (child == 0) {
      Journal journal(path_);
      for (int k = 0; k < 500; ++k) journal.keep({kill, k}, std::string(100, 'x'));
      ::pause();
    }
    while (size_of(path_) < before + 500 + 311 * kill) ::usleep(100);
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    Journal journal(path_);
    int k = 0;
    while (journal.find({kill, k}) != nullptr) EXPECT_EQ(*journal.find({kill, k++}), std::string(100, 'x'));
    EXPECT_GT(k, 0);
    EXPECT_EQ(journal.find({kill, k + 1}), nullptr);
    held += k;
  }
  std::ifstream in(path_);
  int lines = 0;
  for (std::string line; std::getline(in, line);) ++lines;
  EXPECT_GE(lines, held);
}

TEST_F(AJournal, IgnoresAnIncompleteLine) {
  Journal(path_).keep("a", 1);
  std::ofstream(path_, std::ios::app) << R"({"settings":"b","res)";
  Journal(path_).keep("c", 3);
  const Journal again(path_);
  ASSERT_NE(again.find("a"), nullptr);
  EXPECT_EQ(again.find("b"), nullptr);
  ASSERT_NE(again.find("c"), nullptr);
  EXPECT_EQ(*again.find("c"), 3);
  EXPECT_THROW(Journal("/no-such-folder/journal"), InvalidInput);
}

// The case in the journal is not repeated.
TEST_F(AJournal, LetsARunContinue) {
  BoardRequest request;
  request.arms = {"pick-scara"};
  request.effects = {"none", "viscous_friction"};
  request.seeds = {1};
  request.options.identification.threads = request.threads;
  request.journal = std::make_shared<Journal>(path_);
  const std::vector<BoardCase> cases = cases_of(request);
  ASSERT_EQ(cases.size(), 2U);
  // The journal of a run that was killed after the first case.
  request.effects = {"none"};
  const std::vector<Outcome> before = play_all(request);
  ASSERT_EQ(before.size(), 1U);
  request.effects = {"none", "viscous_friction"};
  request.journal = std::make_shared<Journal>(path_);
  nlohmann::json marked = *request.journal->find(settings_of(cases[0], request));
  marked[2] = 0.125;
  request.journal->keep(settings_of(cases[0], request), marked);
  const std::vector<Outcome> all = play_all(request);
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].best_gain, 0.125);
  EXPECT_EQ(all[0].group, before[0].group);
  EXPECT_EQ(all[0].verdict.extras, before[0].verdict.extras);
  EXPECT_NE(request.journal->find(settings_of(cases[1], request)), nullptr);
  // With any other setting it is another case.
  request.options.thresholds.smallest_gain *= 2.0;
  EXPECT_EQ(request.journal->find(settings_of(cases[0], request)), nullptr);
}

}  // namespace
}  // namespace veridyn::seek
