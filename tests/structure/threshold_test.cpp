#include <gtest/gtest.h>

#include <set>
#include <string>

#include "veridyn/diagnosis/thresholds.hpp"
#include "veridyn/math/require.hpp"

namespace {

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

TEST(Thresholds, AreFoundByNameAndASimilarNameIsSuggested) {
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
