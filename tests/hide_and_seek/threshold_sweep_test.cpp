#include "hide_and_seek/threshold_sweep.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <set>

#include "diagnosis/comparison/comparison_numbers.hpp"
#include "identification/estimation/estimation_numbers.hpp"
#include "hide_and_seek/sweep_board.hpp"
#include "identification/fleet/fleet_numbers.hpp"
#include "identification/identification_numbers.hpp"
#include "recordings/quality/quality_numbers.hpp"
#include "veridyn/math/require.hpp"
#include "diagnosis/watch/watch_numbers.hpp"

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

// Of the rooms of swept_rooms().
const std::map<std::string, std::string>& sweep_files() {
  static const std::map<std::string, std::string> kAll = {{"quality", "recordings/quality/quality_sweeps.csv"},
                                                          {"estimation", "identification/estimation/estimation_sweeps.csv"},
                                                          {"watch", "diagnosis/watch/watch_sweeps.csv"},
                                                          {"compare", "diagnosis/comparison/comparison_sweeps.csv"},
                                                          {"fleet", "identification/fleet/fleet_sweeps.csv"},
                                                          {"identification", "identification/identification_sweeps.csv"}};
  return kAll;
}

std::string in_source(const std::string& file) { return std::string(VERIDYN_SOURCE_DIR) + "/src/" + file; }

// Sweeps are of the numbers as they are; `veridyn-hide-and-seek sweeps --of ROOM -o FILE` makes those that are missing.
template <typename Numbers>
void expect_all_swept(const std::vector<TableNumber<Numbers>>& table, const std::string& room) {
  std::size_t bytes = 0;
  for (const TableNumber<Numbers>& one : table) bytes += one.whole ? sizeof(int) : sizeof(double);
  EXPECT_LT(sizeof(Numbers) - bytes, table.size() * sizeof(int)) << room << ": a number is not in the table";
  std::ifstream file(in_source(sweep_files().at(room)));
  ASSERT_TRUE(file.good()) << room;
  std::string line;
  std::getline(file, line);
  std::set<std::string> swept;
  while (std::getline(file, line)) {
    const std::size_t one = line.find(','), two = line.find(',', one + 1);
    ASSERT_NE(two, std::string::npos) << line;
    const double factor = std::stod(line.substr(one + 1)), value = std::stod(line.substr(two + 1));
    const TableNumber<Numbers>& number = number_named(table, line.substr(0, one));
    swept.insert(number.name);
    EXPECT_NEAR(value, factor * number.in(Numbers()), 1e-5 * value) << line;
  }
  for (const TableNumber<Numbers>& one : table) EXPECT_EQ(swept.count(one.name), 1U) << room << ": " << one.name << " has no sweep";
}

TEST(ThresholdSweep, EveryRoomsNumbersAreSwept) {
  expect_all_swept(quality_numbers(), "quality");
  expect_all_swept(estimation_numbers(), "estimation");
  expect_all_swept(watch_numbers(), "watch");
  expect_all_swept(comparison_numbers(), "compare");
  expect_all_swept(fleet_numbers(), "fleet");
  expect_all_swept(identification_numbers(), "identification");
  for (const std::string& room : swept_rooms()) EXPECT_EQ(sweep_files().count(room), 1U) << room;
}

}  // namespace
}  // namespace veridyn::seek
