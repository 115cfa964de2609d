#include "dvrk/run/run_json.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <string>
#include <utility>

namespace veridyn::dvrk {
namespace {

TEST(RunJson, StatesWhetherPowerOffWasConfirmed) {
  for (const auto& [power, word] : {std::pair{OffState::kNotAsked, "not asked"},
                                    {OffState::kConfirmed, "confirmed"},
                                    {OffState::kPowerOn, "not confirmed"},
                                    {OffState::kAmpsOn, "not confirmed"},
                                    {OffState::kUnknown, "not confirmed"}}) {
    RunResult run;
    run.power = power;
    const auto json = nlohmann::json::parse(to_json(run, FaultLog(), "run", "PSM1"));
    EXPECT_EQ(json.at("power_off"), word);
    EXPECT_EQ(json.at("boards_say"), describe(power));
    EXPECT_EQ(json.at("command"), "dvrk run");
    EXPECT_TRUE(json.at("faults").empty());
  }
}

TEST(RunJson, FaultsHaveConditionNumberBoardAndChannel) {
  FaultLog faults;
  faults.note(Condition::kRelayOpen, 1.5, 1, 2);
  faults.note(Condition::kRelayOpen, 2.5, 1, 2);
  const auto list = nlohmann::json::parse(to_json(RunResult(), faults, "run", "PSM1")).at("faults");
  ASSERT_EQ(list.size(), 1U);
  EXPECT_EQ(list[0].at("condition"), number_in_section_17(Condition::kRelayOpen));
  EXPECT_EQ(list[0].at("name"), describe(Condition::kRelayOpen));
  EXPECT_EQ(list[0].at("count"), 2);
  EXPECT_EQ(list[0].at("board"), 1);
  EXPECT_EQ(list[0].at("channel"), 3);  // from one
}

}  // namespace
}  // namespace veridyn::dvrk
