#include "hide_and_seek/threshold_sweep.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "hide_and_seek/sweep_board.hpp"
#include "identification/check/check_thresholds.hpp"
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

std::string printed(void (*print)(const std::string&), const std::string& sweeps) {
  testing::internal::CaptureStdout();
  print(std::string(VERIDYN_SOURCE_DIR) + "/src/" + sweeps);
  return testing::internal::GetCapturedStdout();
}

TEST(ThresholdSweep, TheTablesOfTheDocsAreThoseOfTheFiles) {
  std::ifstream file(std::string(VERIDYN_SOURCE_DIR) + "/docs/numbers.md");
  ASSERT_TRUE(file.good());
  const std::string docs((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  EXPECT_NE(docs.find(printed(print_thresholds, "diagnosis/threshold_sweeps.csv")), std::string::npos);
  EXPECT_NE(docs.find(printed(print_check_numbers, "identification/check/check_sweeps.csv")), std::string::npos);
}

// A factor of 1 is the check itself, and another number gives another answer.
TEST(ThresholdSweep, TheBoardOfTheCheckMovesWithItsNumbers) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "veridyn-check-board";
  const SweptRoom room = check_room(811, folder.string());
  const auto swapped = std::find_if(room.cases.begin(), room.cases.end(),
                                    [](const RoomCase& one) { return one.name == "swapped torques psm-3dof"; });
  ASSERT_NE(swapped, room.cases.end());
  EXPECT_TRUE(swapped->ask("better", 1.0).right) << swapped->ask("better", 1.0).said;
  EXPECT_FALSE(swapped->ask("better", 100.0).right);
  EXPECT_FALSE(swapped->ask("fewest_rows", 100.0).right);
  EXPECT_EQ(room.value("better"), CheckThresholds().better);
  EXPECT_THROW(room.value("beter"), InvalidInput);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace veridyn::seek
