#include "diagnosis/candidates.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/math/require.hpp"

// The causes that diagnosis, payload and watch test.

namespace veridyn {
namespace {

std::multiset<std::string> texts(const Model& arm, const std::vector<Candidate>& all) {
  std::multiset<std::string> out;
  for (const Candidate& c : all) out.insert(to_text(arm, c.cause));
  return out;
}

TEST(Candidates, AreListedOnceAndDifferFromEachOther) {
  const Model arm = read_model("psm-3dof");
  for (const bool changes : {false, true}) {
    const std::vector<Candidate> all = candidates(arm, {{}, changes, {}});
    EXPECT_GT(all.size(), 40U);
    std::set<std::string> seen;
    for (const Candidate& c : all) {
      const std::string from = c.from ? std::to_string(c.from->value) : "";
      EXPECT_TRUE(seen.insert(text(to_text(arm, c.cause), " along ", c.axis.coefficients.transpose(), " from ", from, c.cause.index(), is_changed_constant(c))).second)
          << to_text(arm, c.cause);
      EXPECT_EQ(c.joint.has_value(), acting_joint(arm, c.cause).has_value());
    }
  }
}

TEST(Candidates, DoNotActOnJointsAtRest) {
  const Model arm = read_model("planar-2r");
  const Scope all{{"joint_spring", "time_delay"}, false, {}};
  EXPECT_EQ(texts(arm, candidates(arm, all)),
            (std::multiset<std::string>{"joint_spring:shoulder", "joint_spring:elbow", "time_delay:arm",
                                        "time_delay:shoulder", "time_delay:elbow"}));
  Scope some = all;
  some.still = {true, false};
  EXPECT_EQ(texts(arm, candidates(arm, some)),
            (std::multiset<std::string>{"joint_spring:elbow", "time_delay:arm", "time_delay:elbow"}));
  some.still = {true, true};
  EXPECT_TRUE(candidates(arm, some).empty());
}

// A load is a cause only if the values of the bodies are known.
TEST(Candidates, ContainLoadsOnlyAgainstAModel) {
  const Model arm = read_model("planar-2r");
  EXPECT_TRUE(candidates(arm, {{AddedLoad::kName}, false, {}}).empty());
  const std::vector<Candidate> loads = candidates(arm, {{AddedLoad::kName}, true, {}});
  EXPECT_EQ(loads.size(), payload_frames(arm).size());
  EXPECT_TRUE(std::all_of(loads.begin(), loads.end(), [](const Candidate& c) { return is_load(c); }));
}

// A watch tests the effects that differ from day to day, and sensor errors that begin suddenly.
TEST(Candidates, WithSuddenOnsetAreASubsetOfAllCandidates) {
  const Model arm = read_model("psm-3dof");
  const std::vector<FrameIndex> loads = payload_frames(arm);
  const std::vector<Candidate> all = candidates(arm, {{}, true, {}});
  const std::vector<Candidate> sudden = sudden_candidates(arm, loads);
  const std::multiset<std::string> known = texts(arm, all);
  size_t of_joints = 0;
  for (const Candidate& c : sudden) {
    of_joints += std::holds_alternative<NewEffect>(c.cause) ? 1 : 0;
    EXPECT_GE(known.count(to_text(arm, c.cause)), 1U) << to_text(arm, c.cause);
    if (!is_channel(c)) continue;
    const auto* sensor = dynamic_cast<const SensorError*>(channel_effect(effect_of(c.cause)));
    ASSERT_NE(sensor, nullptr);
    EXPECT_TRUE(sensor->may_begin_suddenly());
  }
  EXPECT_EQ(of_joints, 3U * 3U);  // offset, level and damping of three joints
  EXPECT_EQ(std::count_if(sudden.begin(), sudden.end(), [](const Candidate& c) { return is_load(c); }),
            static_cast<long>(loads.size()));
}

}  // namespace
}  // namespace veridyn
