#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>

// What stands once: one solver of the diagnosis, one jackknife, one engine of random numbers, one
// file of regressor columns that span a space. A second one drifts away from the first.

namespace {

namespace fs = std::filesystem;

std::string without_comments(const std::string& path) {
  std::ifstream stream(path);
  std::string out;
  for (std::string line; std::getline(stream, line);) out += line.substr(0, line.find("//")) + "\n";
  return out;
}

// Files below `folder` in which the pattern stands, comments aside.
std::set<std::string> files_with(const std::string& folder, const std::regex& pattern) {
  std::set<std::string> out;
  for (const char* top : {"src", "include/veridyn"}) {
    const fs::path root = fs::path(VERIDYN_SOURCE_DIR) / top;
    if (!fs::exists(root / folder)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
      const std::string kind = entry.path().extension().string();
      if (kind != ".cpp" && kind != ".hpp") continue;
      if (std::regex_search(without_comments(entry.path().string()), pattern))
        out.insert(fs::relative(entry.path(), root).generic_string());
    }
  }
  return out;
}

using Files = std::set<std::string>;

TEST(SingleSites, EstimatingRoomsHaveOneSolver) {
  const std::regex solver("LDLT<|LLT<|HouseholderQR<|\\bldlt\\(\\)|\\bllt\\(\\)|[a-z]*[hH]ouseholderQr"
                          "\\(\\)|BDCSVD<|JacobiSVD<|fullPivLu|partialPivLu");
  // The stages have one, the search has one; a load is fitted to both sides of zero.
  EXPECT_EQ(files_with("diagnosis", solver), (Files{"diagnosis/evidence/clustered_fit.cpp", "diagnosis/evidence/clustered_fit.hpp",
                                                    "diagnosis/load_fit.cpp", "diagnosis/search/score.cpp", "diagnosis/search/score.hpp",
                                                    "diagnosis/watch/smoothed_rows.cpp"}));  // a filter
  EXPECT_EQ(files_with("identification/fleet", solver), Files{});
}

// (g - 1) / g is the jackknife's; whoever writes it has one of his own.
TEST(SingleSites, TheJackknifeIsOne) {
  const std::regex share("\\((\\w+|\\w+\\.0) - 1\\.0\\) / \\w+");
  const std::regex centred("rowwise\\(\\)\\.mean\\(\\)");
  Files both = files_with("", centred);
  for (const std::string& file : files_with("", share)) {
    if (both.count(file) != 0) {
      EXPECT_EQ(file, "math/clustered_statistics.hpp");
    }
  }
  EXPECT_EQ(both.count("math/clustered_statistics.hpp"), 1U);
}

TEST(SingleSites, OneEngineMakesRandomNumbers) {
  EXPECT_EQ(files_with("", std::regex("std::(mt19937|minstd_rand|default_random_engine|ranlux)")),
            (Files{"math/random_numbers.hpp"}));
}

// Where values are ordered up to a place: the median, a quantile of rows with gaps, a trimmed sum.
TEST(SingleSites, TheMedianIsOne) {
  EXPECT_EQ(files_with("", std::regex("nth_element")),
            (Files{"diagnosis/unnamed/dependence.cpp",  // any quantile
                   "math/median.hpp", "recordings/mending/mended_rows.cpp",  // any quantile
                   "recordings/quality/quality_checks.cpp",
                   "recordings/recording_period.cpp"}));
}

// Other folders ask for facts of an effect, or for its columns along a motion.
TEST(SingleSites, EffectsRunSampleBySampleWhereLoopsAre) {
  const Files with = files_with("", std::regex("\\bBoundEffect\\b"));
  EXPECT_GE(with.size(), 3U);
  for (const std::string& file : with) {
    const std::string folder = file.substr(0, file.find('/'));
    if (folder == "effects" || folder == "regressor" || folder == "control") continue;
    ADD_FAILURE() << file << ": found BoundEffect, expected EffectFacts or columns_along().";
  }
}

TEST(SingleSites, OneFileDefinesBaseParameters) {
  EXPECT_EQ(files_with("", std::regex("\\nBaseParameters base_parameters\\(")),
            (Files{"identification/base_parameters.cpp", "identification/base_parameters.hpp"}));
}

}  // namespace
