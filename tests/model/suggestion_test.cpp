#include "model/suggestion.hpp"

#include <gtest/gtest.h>

namespace veridyn {
namespace {

const std::vector<std::string> kNames{"yaw", "pitch", "insertion"};

TEST(Suggestion, OneTypingErrorIsCorrected) {
  EXPECT_EQ(did_you_mean("ptich", kNames), " (did you mean 'pitch'?)");
  EXPECT_EQ(did_you_mean("insertoin", kNames), " (did you mean 'insertion'?)");
  EXPECT_EQ(did_you_mean("YAW", kNames), " (did you mean 'yaw'?)");
}

TEST(Suggestion, NothingIsSuggestedForDissimilarNames) {
  EXPECT_EQ(did_you_mean("gripper", kNames), "");
  EXPECT_EQ(did_you_mean("yaw", {}), "");
}

TEST(Suggestion, TheMostSimilarNameIsListedFirst) {
  EXPECT_EQ(by_similarity("inserton", kNames).front(), "insertion");
  EXPECT_EQ(by_similarity("inserton", kNames).size(), kNames.size());
}

}  // namespace
}  // namespace veridyn
