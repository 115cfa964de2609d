#include "dvrk/protocol/fault_log.hpp"

#include <gtest/gtest.h>

#include <string>

#include "dvrk/run/loop_timing.hpp"

// Texts about faults and late cycles, with the units of section 12.

namespace veridyn::dvrk {
namespace {

TEST(FaultLog, FoundValuesArePrintedWithTheirUnit) {
  EXPECT_EQ(describe_found(Condition::kTemperature, 0x8F34), "71.5 deg C and 26 deg C");
  EXPECT_EQ(describe_found(Condition::kTemperature, 0xFF32), "none and 25 deg C");
  EXPECT_EQ(describe_found(Condition::kTemperature, 0x32FF), "25 deg C and none");
  EXPECT_EQ(describe_found(Condition::kPot, 0x8000), "2.25 V of 4.5 V");
  EXPECT_EQ(describe_found(Condition::kOutOfBounds, 0x8000), "0 A before calibration");
  EXPECT_EQ(describe_found(Condition::kOutOfBounds, 0xC000), "3.12 A before calibration");  // 6.25 A / 2
  EXPECT_EQ(describe_found(Condition::kTimestamp, 49151), "1 ms");  // one tick more than the word
  for (const Condition bytes : {Condition::kWrongSize, Condition::kStaleReply, Condition::kTooLarge})
    EXPECT_EQ(describe_found(bytes, 28), "28 bytes");
  EXPECT_EQ(describe_found(Condition::kNoSupply, 0x46BF0F0F), "0x46bf0f0f");
}

TEST(FaultLog, TheReportHasOneLinePerConditionWithItsLastBoard) {
  FaultLog log;
  EXPECT_EQ(log.report(), "");
  log.note(Condition::kPot, 1.0, 6, 0, 0);
  log.note(Condition::kPot, 2.0, 7, 3, 0x8000);
  log.note(Condition::kGenerationChanged, 3.0, {}, {}, 4);
  log.note(Condition::kTemperature, 4.0, 6, {}, 0x8F34);
  EXPECT_EQ(log.report(), std::string(describe(Condition::kGenerationChanged)) + " (1 times, found 0x4)\n" +
                              describe(Condition::kTemperature) + " (1 times, board 6, found 71.5 deg C and 26 deg C)\n" +
                              describe(Condition::kPot) + " (2 times, board 7, channel 4, found 2.25 V of 4.5 V)\n");
  EXPECT_EQ(log[Condition::kPot].last, 2.0);
  EXPECT_EQ(log.count(Condition::kNoReply), 0);
  log.clear();
  EXPECT_EQ(log.report(), "");
}

TEST(FaultLog, ConditionNumbersAreThoseOfTheSpecification) {
  for (int k = 1; k <= 30; ++k) EXPECT_EQ(number_in_section_17(static_cast<Condition>(k)), k);
  EXPECT_EQ(number_in_section_17(Condition::kTemperature), 23);
  EXPECT_EQ(number_in_section_17(Condition::kPot), 23);
}

// The largest unplanned part gives the gap its reason; of the system's two parts the larger is named.
TEST(LoopTiming, ALateCycleIsAttributedToItsLargestUnplannedPart) {
  const struct {
    WriteGap gap;
    LateReason reason;
    const char* words;
  } cases[] = {
      {{0.0, 0.010, 0.0, 0.001, 0.002, 0.005, 0.001}, LateReason::kOwn, "this program worked for 5.00 ms"},
      {{0.0, 0.010, 0.0, 0.001, 0.005, 0.002, 0.001}, LateReason::kReplies, "replies took 5.00 ms"},
      {{0.0, 0.010, 0.0, 0.004, 0.003, 0.003, 0.001}, LateReason::kSystem, "the system woke this program 4.00 ms late"},
      {{0.0, 0.010, 0.0, 0.001, 0.003, 0.003, 0.004}, LateReason::kSystem, "the system interrupted this program for 4.00 ms"},
      {{0.0, 0.010, 0.0095, 0.0, 0.0, 0.0009, 0.0}, LateReason::kOwn, "as planned"},
      {{0.0, 0.010, 0.0080, 0.0, 0.0, 0.0011, 0.0}, LateReason::kOwn, "this program worked for 1.10 ms"},
  };
  for (const auto& c : cases) {
    EXPECT_EQ(reason_of(c.gap), c.reason) << c.words;
    EXPECT_EQ(describe_reason(c.gap), c.words);
  }
}

TEST(LoopTiming, TheRateIsTheNumberOfCyclesOverTime) {
  LoopTiming timing;
  timing.rate = 1500.0;
  EXPECT_EQ(timing.measured_rate(), 1500.0);
  timing.cycles = 300;
  timing.seconds = 0.25;
  EXPECT_EQ(timing.measured_rate(), 1200.0);
}

}  // namespace
}  // namespace veridyn::dvrk
