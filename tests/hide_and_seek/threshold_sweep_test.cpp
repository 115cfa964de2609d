#include "hide_and_seek/threshold_sweep.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "hide_and_seek/sweep_board.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::seek {
namespace {

TEST(ThresholdSweep, CasesAreAskedForTheNumbersOfTheirQuestion) {
  const SweepCase contact{"", "contact snag", {}}, nothing{"", "nothing", {}}, selection{"", "selection change", {}};
  EXPECT_TRUE(concerns(contact, "contact_peak"));
  EXPECT_TRUE(concerns(contact, "snag_widest"));
  EXPECT_FALSE(concerns(contact, "tie"));
  EXPECT_TRUE(concerns(selection, "tie"));
  EXPECT_TRUE(concerns(selection, "smallest_change"));
  EXPECT_FALSE(concerns(selection, "constant_gain"));
  for (const ThresholdEntry& entry : threshold_table()) EXPECT_TRUE(concerns(nothing, entry.name)) << entry.name;
}

TEST(ThresholdSweep, TheTableShowsWhatMultiplesChanged) {
  const std::string file = (std::filesystem::path(testing::TempDir()) / "sweeps.csv").string();
  const std::string header = "number,factor,value,cases,right,gained,lost,other answers,which,seed,date\n";
  std::ofstream(file) << header << "tie,1,0.95,9,8,0,0,0,,811,2026-11-23\n"
                      << "tie,0.5,0.475,9,7,1,2,3,-a; -b; +c,811,2026-11-23\n"
                      << "withdrawals,2,6,5,4,0,0,0,,811,2026-11-23\n";
  testing::internal::CaptureStdout();
  print_thresholds(file);
  const std::string shown = testing::internal::GetCapturedStdout();
  EXPECT_NE(shown.find("| 0.5: +1 -2 cases, 3 other answers |"), std::string::npos) << shown;
  EXPECT_NE(shown.find("| nothing |"), std::string::npos) << shown;
  const auto message = [&file] {
    try {
      print_thresholds(file);
    } catch (const InvalidInput& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  std::ofstream(file) << header << "tie,0.5,0.475\n";
  EXPECT_NE(message().find(file + ":2: found 3 fields, expected 11."), std::string::npos) << message();
  std::ofstream(file) << "number,value\n";
  EXPECT_NE(message().find(file + ":1: found no sweeps"), std::string::npos) << message();
}

}  // namespace
}  // namespace veridyn::seek
