#include <gtest/gtest.h>

#include <cmath>

#include "support/refusal.hpp"
#include "veridyn/diagnosis/watch.hpp"
#include "diagnosis/watch/onsets.hpp"

// What a watch does with time: it learns anew, takes back what is taken off, and reports at the end.

namespace veridyn {
namespace {

const WatchedArm& psm() {
  static const WatchedArm kArm;
  return kArm;
}

std::vector<WatchEvent> of(const std::vector<WatchEvent>& events, WatchStage stage) {
  std::vector<WatchEvent> out;
  for (const WatchEvent& e : events)
    if (e.stage == stage) out.push_back(e);
  return out;
}

std::string events_text(const std::vector<WatchEvent>& events) {
  std::string out;
  for (const WatchEvent& e : events) out += std::string(name_of(e.stage)) + ": " + e.sentence + "\n";
  return out;
}

// A load that is put on at 5 s and taken off at 20 s is one change, which is over again.
TEST(WatchLife, RemovingALoadEndsItsEvent) {
  const MotionSamples motion = watched_waves(30.0);
  const Recording without = psm().recorded(motion, {}, 1), with = psm().recorded(motion, {"payload:tool:mass=0.3"}, 1);
  const std::vector<WatchEvent> events = psm().watched(joined(joined(without, with, 5.0, 30.0), without, 20.0, 30.0));
  const std::vector<WatchEvent> over = of(events, WatchStage::kOver);
  ASSERT_EQ(over.size(), 1U) << events_text(events);
  EXPECT_EQ(over[0].text, "payload:tool");
  EXPECT_EQ(over[0].id, of(events, WatchStage::kNamed).front().id);
  EXPECT_NEAR(over[0].since, 5.0, 0.5);
  EXPECT_NEAR(over[0].until, 20.0, 0.5);
  EXPECT_EQ(events.back().stage, WatchStage::kOver) << events_text(events);
}

// A load that is there when the watch begins counts as known, and is missed when it is taken off.
TEST(WatchLife, RemovingALoadThatWasThereFromTheBeginningIsAChange) {
  const MotionSamples motion = watched_waves(30.0);
  const Recording without = psm().recorded(motion, {}, 1), with = psm().recorded(motion, {"payload:tool:mass=0.3"}, 1);
  const std::vector<WatchEvent> events = psm().watched(joined(with, without, 15.0, 30.0));
  ASSERT_EQ(of(events, WatchStage::kPresent).size(), 1U) << events_text(events);
  const std::vector<WatchEvent> suspicions = of(events, WatchStage::kSuspected);
  ASSERT_EQ(suspicions.size(), 1U) << events_text(events);
  EXPECT_NEAR(suspicions[0].time, 15.0, 1.0);
}

// Waves of a quarter of their size, and from 12 to 14 s up to their whole size.
MotionSamples growing_waves(double seconds) {
  MotionSamples m = watched_waves(seconds);
  for (Eigen::Index k = 0; k < m.rows(); ++k) {
    const double x = std::min(1.0, std::max(0.0, (m.time[k] - 12.0) / 2.0));
    const double s = 0.25 + 0.75 * x * x * x * (10.0 - 15.0 * x + 6.0 * x * x);
    const double ds = 0.75 * 30.0 * x * x * (1.0 - x) * (1.0 - x) / 2.0;
    const double dds = 0.75 * 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) / 4.0;
    for (int j = 0; j < 3; ++j) {
      const double middle = j == 2 ? 0.12 : 0.0;
      const double q = m.q(k, j) - middle, dq = m.dq(k, j), ddq = m.ddq(k, j);
      m.q(k, j) = middle + s * q;
      m.dq(k, j) = s * dq + ds * q;
      m.ddq(k, j) = s * ddq + 2.0 * ds * dq + dds * q;
    }
  }
  return m;
}

// The arm begins a larger motion than it learned from: the watch learns again and gives no alarm, and sees
// afterwards what it saw before.
TEST(WatchLife, ANewMotionIsAddedToTheNoiseModel) {
  const MotionSamples motion = growing_waves(40.0);
  const Recording quiet = psm().recorded(motion, {}, 1);
  const Recording changed = joined(quiet, psm().recorded(motion, {"payload:tool:mass=0.3"}, 1), 30.0, 40.0);
  Watch watch(psm().arm);
  std::vector<double> learned;  // [s] times of steps that were learned from again
  watch.on_step([&](const WatchState& state) {
    if (state.learning && state.time > 5.0) learned.push_back(state.time);
  });
  watch.add(changed);
  watch.finish();
  ASSERT_FALSE(learned.empty());
  EXPECT_GT(learned.front(), 12.0);
  EXPECT_LT(learned.back(), 25.0);
  ASSERT_FALSE(watch.events().empty());
  EXPECT_GT(watch.events().front().time, 30.0) << events_text(watch.events());
  const std::vector<WatchEvent> named = of(watch.events(), WatchStage::kNamed);
  ASSERT_FALSE(named.empty()) << events_text(watch.events());
  EXPECT_EQ(named.back().text, "payload:tool") << events_text(watch.events());
}

// Rows that end while a change is being isolated, or refined: it is named, or refined, with what there is.
TEST(WatchLife, TheEndReportsOpenChanges) {
  const MotionSamples motion = watched_waves(12.0);
  const Recording before = psm().recorded(motion, {}, 1), after = psm().recorded(motion, {"payload:tool:mass=0.3"}, 1);
  Watch watch(psm().arm);
  watch.add(joined(before, after, 5.0, 6.5));
  ASSERT_FALSE(watch.events().empty());
  EXPECT_EQ(watch.events().back().stage, WatchStage::kSuspected) << events_text(watch.events());
  EXPECT_TRUE(watch.state().alarmed);
  const std::vector<WatchEvent> last = watch.finish();
  ASSERT_FALSE(last.empty());
  EXPECT_TRUE(last.back().stage == WatchStage::kNamed || last.back().stage == WatchStage::kRefined) << events_text(last);
  EXPECT_EQ(last.back().id, 1);
}

// However unlike the causes are, one is named in this time.
TEST(WatchLife, ACauseIsNamedInTime) {
  const MotionSamples motion = watched_waves(12.0);
  const Recording changed =
      joined(psm().recorded(motion, {}, 1), psm().recorded(motion, {"payload:tool:mass=0.3"}, 1), 5.0, 12.0);
  WatchOptions hasty;
  hasty.longest_naming = 0.5;
  Watch watch(psm().arm, hasty);
  watch.add(changed);
  const std::vector<WatchEvent> suspected = of(watch.events(), WatchStage::kSuspected);
  ASSERT_FALSE(suspected.empty());
  const double told = suspected.front().time;
  double answered = 1e300;
  for (const WatchEvent& e : watch.events())
    if (e.stage == WatchStage::kNamed || e.stage == WatchStage::kUnnamed || e.stage == WatchStage::kOver) answered = std::min(answered, e.time);
  EXPECT_LE(answered - told, 0.5 + 2.0 * hasty.step) << events_text(watch.events());
}

// A watch that learned from the recordings of other days tells a change at once, though not in the first seconds, and
// the differences of those days are none.
TEST(WatchLife, RecordingsOfOtherDaysAreLearned) {
  const MotionSamples motion = watched_waves(30.0);
  const Recording quiet = psm().recorded(motion, {}, 7);
  const Recording changed = joined(quiet, psm().recorded(motion, {"payload:tool:mass=0.3"}, 7), 10.0, 16.0);
  for (const bool same_day : {true, false}) {
    Watch watch(psm().arm);
    watch.learn(psm().recorded(motion, same_day ? std::vector<std::string>{} : std::vector<std::string>{"torque_offset:yaw:offset=0.2"}, 8));
    watch.add(changed);
    watch.finish();
    ASSERT_FALSE(watch.events().empty());
    EXPECT_GT(watch.events().front().time, 10.0) << events_text(watch.events());
    const std::vector<WatchEvent> named = of(watch.events(), WatchStage::kNamed);
    ASSERT_FALSE(named.empty()) << events_text(watch.events());
    EXPECT_EQ(named.back().text, "payload:tool") << events_text(watch.events());
    EXPECT_NEAR(named.back().value, 0.3, 0.03) << events_text(watch.events());
  }
  Watch watch(psm().arm);
  EXPECT_TRUE(refuses_with("less than two seconds", [&] { watch.learn(rows_of(quiet, 0, 400)); }));
  EXPECT_TRUE(refuses_with("less than two seconds", [&] { watch.learn(rows_of(quiet, 0, 0)); }));
}

// The rows' clock is set back by 11 s at 12 s. What was named before stays known and raises no alarm again; a change
// afterwards is one more, with times of the new clock; and what was named is over by that clock.
TEST(WatchLife, ASetBackClockKeepsTheNoiseModel) {
  const MotionSamples motion = watched_waves(34.0);
  const Recording without = psm().recorded(motion, {}, 1);
  const Recording with = psm().recorded(motion, {"payload:tool:mass=0.3"}, 1);
  const Recording more = psm().recorded(motion, {"payload:tool:mass=0.3", "torque_offset:yaw:offset=0.3"}, 1);
  const Recording less = psm().recorded(motion, {"torque_offset:yaw:offset=0.3"}, 1);
  Recording rows = joined(joined(joined(without, with, 5.0, 34.0), more, 16.0, 34.0), less, 26.0, 34.0);
  const auto cut = static_cast<Eigen::Index>(12.0 * WatchedArm::kRate);
  rows.time.tail(rows.rows() - cut).array() -= 11.0;
  Watch watch(psm().arm);
  for (int k = 0; k < rows.rows(); k += 37) watch.add(rows_of(rows, k, std::min(37, rows.rows() - k)));
  watch.finish();
  const std::vector<WatchEvent>& events = watch.events();
  EXPECT_NEAR(watch.state().set_back, 11.0, 1e-6);
  EXPECT_NEAR(watch.state().blind, 0.25, 0.02);
  EXPECT_NEAR(watch.state().heard, 23.0, 0.01);
  const std::vector<WatchEvent> blind = of(events, WatchStage::kBlind), named = of(events, WatchStage::kNamed),
                                over = of(events, WatchStage::kOver), suspected = of(events, WatchStage::kSuspected);
  ASSERT_EQ(blind.size(), 1U) << events_text(events);
  EXPECT_NEAR(blind[0].since, 12.0, 0.02);
  EXPECT_NEAR(blind[0].time, 12.25, 0.03);
  ASSERT_EQ(named.size(), 2U) << events_text(events);
  EXPECT_EQ(named[0].text, "payload:tool");
  EXPECT_EQ(named[1].text, "torque_offset:yaw");
  EXPECT_NEAR(named[1].since, 5.0, 0.5);
  EXPECT_EQ(suspected.size(), 3U) << events_text(events);  // the load, the offset, the load that is taken off
  ASSERT_EQ(over.size(), 1U) << events_text(events);
  EXPECT_EQ(over[0].id, named[0].id);
  EXPECT_NEAR(over[0].since, 5.0 - 11.0, 0.5);
  EXPECT_NEAR(over[0].until, 26.0 - 11.0, 0.5);
}

// A change that is open when the clock is set back is answered with what there is, as at the end.
TEST(WatchLife, ASetBackClockEndsOpenEvents) {
  const MotionSamples motion = watched_waves(20.0);
  Recording rows = joined(psm().recorded(motion, {}, 1), psm().recorded(motion, {"payload:tool:mass=0.3"}, 1), 11.0, 20.0);
  const auto cut = static_cast<Eigen::Index>(12.0 * WatchedArm::kRate);
  rows.time.tail(rows.rows() - cut).array() -= 11.0;
  const std::vector<WatchEvent> events = psm().watched(rows);
  const std::vector<WatchEvent> named = of(events, WatchStage::kNamed);
  ASSERT_EQ(named.size(), 1U) << events_text(events);
  EXPECT_EQ(named[0].text.rfind("payload:", 0), 0U);  // which link carries it is not known after a second
  EXPECT_NEAR(named[0].since, 11.0, 0.5);
  EXPECT_NEAR(named[0].time, 12.0, 0.2);
  for (const WatchEvent& e : events) EXPECT_TRUE(e.id == 1 || e.stage == WatchStage::kBlind) << events_text(events);
}

// A clock that is set back while the noise is learned costs a quarter of a second of it.
TEST(WatchLife, QuietTimeContinuesAcrossASetBackClock) {
  Recording rows = psm().recorded(watched_waves(12.0), {}, 1);
  const auto cut = static_cast<Eigen::Index>(3.0 * WatchedArm::kRate);
  rows.time.tail(rows.rows() - cut).array() -= 2.9;
  Watch watch(psm().arm);
  watch.add(rows);
  EXPECT_FALSE(watch.state().learning);
  EXPECT_NEAR(watch.state().time, 9.0, 0.2);
  ASSERT_EQ(watch.events().size(), 1U) << events_text(watch.events());
  EXPECT_EQ(watch.events()[0].stage, WatchStage::kBlind);
}

TEST(WatchLife, WithoutVelocitiesTheEventsAreTheSame) {
  const MotionSamples motion = watched_waves(16.0);
  Recording changed = joined(psm().recorded(motion, {}, 1), psm().recorded(motion, {"payload:tool:mass=0.3"}, 1), 5.0, 16.0);
  changed.dq.resize(0, 0);
  const std::vector<WatchEvent> named = of(psm().watched(changed), WatchStage::kNamed);
  ASSERT_FALSE(named.empty());
  EXPECT_EQ(named.front().text, "payload:tool");
}

TEST(WatchLife, AnEffectWithoutValuesIsRefused) {
  ModelDescription d = psm().arm.description();
  EffectTerm term;
  term.effect = "viscous_friction";
  term.axis.coefficients = VectorXd::Unit(3, 0);
  d.effects.push_back(term);
  EXPECT_TRUE(refuses_with("has no value", [&] { Watch{Model(d)}; }));
}

TEST(WatchLife, EveryStageHasAName) {
  const WatchStage all[] = {WatchStage::kSuspected, WatchStage::kNamed,   WatchStage::kUnnamed,   WatchStage::kRefined,
                            WatchStage::kOver,      WatchStage::kPresent, WatchStage::kWithdrawn, WatchStage::kBlind};
  const char* names[] = {"suspected", "named", "unnamed", "refined", "over", "present", "withdrawn", "blind"};
  for (int k = 0; k < 8; ++k) EXPECT_STREQ(name_of(all[k]), names[k]);
}

}  // namespace
}  // namespace veridyn
