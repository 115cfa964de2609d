#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <string>

#include "veridyn/diagnosis/thresholds.hpp"
#include "veridyn/math/require.hpp"

// Numbers that decide verdicts stand in one table; numbers that keep arithmetic sound in another
// file. Anywhere else in diagnosis/ there are only 0, 1/2, 1 and 2.

namespace {

namespace fs = std::filesystem;

std::string without_strings_and_comments(const std::string& line) {
  const std::string code = std::regex_replace(line, std::regex(R"("(\\.|[^"\\])*")"), "");
  return code.substr(0, code.find("//"));
}

TEST(Thresholds, NoOtherNumbersStandInDiagnosis) {
  const std::set<std::string> allowed = {"0.0", "0.5", "1.0", "2.0"};
  const std::set<std::string> tables = {"numerics.hpp", "thresholds.cpp", "threshold_sweeps.csv"};
  const std::regex literal(R"((^|[^\w.])(\d+\.\d*([eE][-+]?\d+)?|\d+[eE][-+]?\d+)(?![\w.]))");
  int files = 0;
  for (const auto& entry :
       fs::recursive_directory_iterator(std::string(VERIDYN_SOURCE_DIR) + "/src/diagnosis")) {
    if (!entry.is_regular_file() || tables.count(entry.path().filename().string()) != 0) continue;
    ++files;
    std::ifstream file(entry.path());
    std::string line;
    for (int number = 1; std::getline(file, line); ++number) {
      const std::string code = without_strings_and_comments(line);
      for (std::sregex_iterator it(code.begin(), code.end(), literal), end; it != end; ++it)
        EXPECT_EQ(allowed.count((*it)[2].str()), 1u)
            << entry.path().string() << ":" << number << ": " << (*it)[2].str()
            << " belongs into thresholds.hpp or numerics.hpp";
    }
  }
  EXPECT_GT(files, 30);
}

TEST(Thresholds, TheTableHasAReasonForEveryNumber) {
  using veridyn::Thresholds;
  std::set<std::string> names;
  for (const veridyn::ThresholdEntry& entry : veridyn::threshold_table()) {
    EXPECT_TRUE(names.insert(entry.name).second) << entry.name;
    EXPECT_FALSE(entry.inequality.empty() || entry.reason.empty()) << entry.name;
    EXPECT_NE(entry.inequality.find(entry.name), std::string::npos) << entry.name;
  }
  EXPECT_EQ(names.size() * sizeof(double), sizeof(Thresholds)) << "a number is not in the table";
}

// Sweeps are of the numbers as they are: one that was changed since must be swept again.
TEST(Thresholds, SweepsAreOfTheNumbersAsTheyAre) {
  std::ifstream file(std::string(VERIDYN_SOURCE_DIR) + "/src/diagnosis/threshold_sweeps.csv");
  ASSERT_TRUE(file.good());
  const veridyn::Thresholds now;
  std::string line;
  std::getline(file, line);
  EXPECT_EQ(line.rfind("number,factor,value,", 0), 0u);
  int rows = 0;
  while (std::getline(file, line)) {
    ++rows;
    const size_t one = line.find(','), two = line.find(',', one + 1);
    ASSERT_NE(two, std::string::npos) << line;
    const double factor = std::stod(line.substr(one + 1)), value = std::stod(line.substr(two + 1));
    const veridyn::ThresholdEntry& entry = veridyn::find_threshold(line.substr(0, one));
    EXPECT_NEAR(value, factor * (now.*entry.value), 1e-5 * value) << line;
  }
  EXPECT_GE(rows, 5);
}

TEST(Thresholds, AreFoundByNameAndNearNamesAreProposed) {
  EXPECT_EQ(veridyn::find_threshold("tie").value, &veridyn::Thresholds::tie);
  try {
    veridyn::find_threshold("smalest_gain");
    ADD_FAILURE() << "found what is not there";
  } catch (const veridyn::InvalidInput& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find("'smalest_gain' (did you mean 'smallest_gain'?)"), std::string::npos) << what;
  }
}

}  // namespace
