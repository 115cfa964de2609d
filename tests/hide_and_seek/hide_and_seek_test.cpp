#include <gtest/gtest.h>

#include <filesystem>

#include "hide_and_seek/judge.hpp"

// A few cases of the scoreboard that must never be lost: different arms, different effects, one
// with nothing hidden. The whole board is veridyn-hide-and-seek.

namespace veridyn::seek {
namespace {

struct Played {
  HiddenCase hidden;
  Diagnosis diagnosis;
  Verdict verdict;
};

Played play(const CaseRequest& request) {
  namespace fs = std::filesystem;
  const fs::path folder =
      fs::path(testing::TempDir()) /
      ("hide-and-seek-" +
       std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
  fs::create_directories(folder);
  Played out{hide(request), {}, {}};
  const CaseFiles files = write_case(out.hidden, folder.string());
  DiagnosisOptions options;
  options.identification.threads = 2;
  out.diagnosis = seek_causes(out.hidden, files, folder.string(), options);
  out.verdict = judge(out.hidden, out.diagnosis);
  fs::remove_all(folder);
  return out;
}

TEST(HideAndSeek, NothingHiddenOnThePsm) {
  EXPECT_TRUE(play({"psm-3dof", {}, 1, 0.1, Mode::kBare}).diagnosis.findings.empty());
}

}  // namespace
}  // namespace veridyn::seek
