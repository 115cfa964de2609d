#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "veridyn/diagnosis/thresholds.hpp"
#include "veridyn/math/require.hpp"

// Numbers that decide stand in one table of their room, each with its inequality; in diagnosis/ those
// that keep arithmetic sound stand in another file. Anywhere else there are only 0, 1/2, 1, 2 and the
// factors of units.

namespace {

namespace fs = std::filesystem;

std::string without_strings_and_comments(const std::string& line) {
  const std::string code = std::regex_replace(line, std::regex(R"("(\\.|[^"\\])*")"), "");
  return code.substr(0, code.find("//"));
}

// Literals of a line that are not in a set, without strings and comments.
std::vector<std::string> literals(const std::string& line, const std::regex& form,
                                  const std::set<std::string>& allowed) {
  std::vector<std::string> out;
  const std::string code = without_strings_and_comments(line);
  for (std::sregex_iterator it(code.begin(), code.end(), form), end; it != end; ++it) {
    if (allowed.count((*it)[2].str()) == 0) out.push_back((*it)[2].str());
  }
  return out;
}

const std::regex& decimal() {
  static const std::regex kForm(R"((^|[^\w.])(\d+\.\d*([eE][-+]?\d+)?|\d+[eE][-+]?\d+)(?![\w.]))");
  return kForm;
}

// An integer with a name, beyond 2: counts of things that can be one more.
const std::regex& named_integer() {
  static const std::regex kForm(R"(constexpr [\w:]+ k\w+ = ([3-9]|\d\d+)[uUlL]*;)");
  return kForm;
}

struct Room {
  std::string folder;
  std::set<std::string> tables;
  std::set<std::string> allowed;
  int fewest_files;
  std::vector<std::string> except{};  // where numbers keep arithmetic sound
};

TEST(Thresholds, NoOtherNumbersStandInTheRoomsThatDecide) {
  const std::set<std::string> plain = {"0.0", "0.5", "1.0", "2.0"};
  // Percent, milliseconds, half a turn in degrees, and what no quotient divides by.
  std::set<std::string> units = {"100.0", "1e3", "180.0", "3600.0", "1e-300", "1e300"};
  units.insert(plain.begin(), plain.end());
  const std::set<std::string> spline = {"0.0", "0.5", "1.0", "2.0", "3.0", "4.0", "6.0"};  // of a cubic's polynomials
  const std::vector<Room> rooms = {
      {"diagnosis", {"numbers.hpp", "numerics.hpp", "load_numbers.hpp", "thresholds.cpp"}, plain, 30,
       {"/comparison/", "/watch/", "/candidates/"}},
      {"recordings/quality", {"quality_numbers.hpp"}, units, 10},
      {"identification",
       {"identification_numbers.hpp", "check_thresholds.hpp", "fleet_numbers.hpp"},
       units, 40, {"/feasible/", "/many/", "/estimation/", "/base_parameters.", "/portable_model."}},
      {"diagnosis/comparison", {"comparison_numbers.hpp"}, units, 8},
      {"identification/estimation", {"estimation_numbers.hpp"}, spline, 5},
      {"diagnosis/watch", {"watch_numbers.hpp"}, units, 10}};
  for (const Room& room : rooms) {
    int files = 0;
    for (const auto& entry :
         fs::recursive_directory_iterator(std::string(VERIDYN_SOURCE_DIR) + "/src/" + room.folder)) {
      const std::string path = entry.path().string();
      if (!entry.is_regular_file() || entry.path().extension() == ".csv" ||  // sweeps
          room.tables.count(entry.path().filename().string()) != 0)
        continue;
      if (std::any_of(room.except.begin(), room.except.end(),
                      [&path](const std::string& part) { return path.find(part) != std::string::npos; }))
        continue;
      ++files;
      std::ifstream file(entry.path());
      std::string line;
      for (int number = 1; std::getline(file, line); ++number) {
        std::vector<std::string> wrong = literals(line, decimal(), room.allowed);
        if (std::regex_search(line, named_integer())) wrong.push_back(line);
        for (const std::string& found : wrong)
          ADD_FAILURE() << entry.path().string() << ":" << number << ": " << found << " belongs into "
                        << *room.tables.begin();
      }
    }
    EXPECT_GE(files, room.fewest_files) << room.folder;
  }
}

// In the tables that are headers every number stands below a comment that compares something with it.
TEST(Thresholds, EveryNumberOfARoomHasItsInequality) {
  const std::regex number(R"(^ *(constexpr )?(double|int|long|std::size_t) (\w+.*;)$)");
  const std::regex own_name(R"((\w+)(\[\])? = )");
  for (const std::string name :
       {"src/recordings/quality/quality_numbers.hpp", "src/identification/check/check_thresholds.hpp",
        "src/identification/fleet/fleet_numbers.hpp", "src/diagnosis/comparison/comparison_numbers.hpp",
        "src/diagnosis/watch/watch_numbers.hpp", "src/identification/estimation/estimation_numbers.hpp", "src/identification/identification_numbers.hpp",
        "packages/calibration/src/calibration/links/links_numbers.hpp"}) {
    std::ifstream file(std::string(VERIDYN_SOURCE_DIR) + "/" + name);
    ASSERT_TRUE(file.good()) << name;
    std::string line, comment;
    int numbers = 0;
    bool above = false;  // the line above is a comment
    while (std::getline(file, line)) {
      const bool is_comment = line.find("///") != std::string::npos;
      if (is_comment) comment = above ? comment + line : line;
      above = is_comment;
      if (!std::regex_match(line, number)) continue;
      EXPECT_NE(comment.find_first_of("<>="), std::string::npos) << name << ": " << line;
      for (std::sregex_iterator it(line.begin(), line.end(), own_name), end; it != end; ++it) {
        ++numbers;
        EXPECT_NE(comment.find((*it)[1].str()), std::string::npos) << name << ": " << line;
      }
    }
    EXPECT_GE(numbers, 5) << name;
  }
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

// Sweeps are of the numbers as they are; `veridyn-hide-and-seek sweeps -o FILE` makes those that are missing.
TEST(Thresholds, SweepsAreOfTheNumbersAsTheyAre) {
  std::ifstream file(std::string(VERIDYN_SOURCE_DIR) + "/src/diagnosis/threshold_sweeps.csv");
  ASSERT_TRUE(file.good());
  const veridyn::Thresholds now;
  std::string line;
  std::getline(file, line);
  EXPECT_EQ(line.rfind("number,factor,value,", 0), 0u);
  std::set<std::string> swept;
  while (std::getline(file, line)) {
    const size_t one = line.find(','), two = line.find(',', one + 1);
    ASSERT_NE(two, std::string::npos) << line;
    const double factor = std::stod(line.substr(one + 1)), value = std::stod(line.substr(two + 1));
    const veridyn::ThresholdEntry& entry = veridyn::find_threshold(line.substr(0, one));
    swept.insert(entry.name);
    EXPECT_NEAR(value, factor * (now.*entry.value), 1e-5 * value) << line;
  }
  for (const veridyn::ThresholdEntry& entry : veridyn::threshold_table())
    EXPECT_EQ(swept.count(entry.name), 1u) << entry.name << " has no sweep";
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
