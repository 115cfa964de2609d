#include "veridyn/diagnosis/watch.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "support/refusal.hpp"
#include "veridyn/math/require.hpp"
#include "diagnosis/watch/event_words.hpp"
#include "diagnosis/watch/onsets.hpp"
#include "diagnosis/watch/watch_numbers.hpp"

namespace veridyn {
namespace {

constexpr double kChange = 5.0;  // [s]

const WatchedArm& bench() {
  static const WatchedArm kBench;
  return kBench;
}

Recording recorded(const std::vector<std::string>& hidden, double seconds, unsigned seed) {
  return bench().recorded(watched_waves(seconds), hidden, seed);
}

// The arm as it is, and from kChange on with something hidden in it.
Recording with_change(const std::string& hidden, double seconds, unsigned seed) {
  return joined(recorded({}, seconds, seed), recorded({hidden}, seconds, seed), kChange, seconds);
}

std::vector<WatchEvent> watched(const Recording& recording) {
  return bench().watched(recording);
}

const WatchEvent* first(const std::vector<WatchEvent>& events, WatchStage stage) {
  for (const WatchEvent& e : events)
    if (e.stage == stage) return &e;
  return nullptr;
}

std::string all_of(const std::vector<WatchEvent>& events) {
  std::string out;
  for (const WatchEvent& e : events) out += std::string(name_of(e.stage)) + ": " + e.sentence + "\n";
  return out;
}

struct Case {
  const char* name;
  const char* hidden;
  const char* cause;
  double size;          // as it was put in
  double latest_alarm;  // [s] after the change
  double latest_name;   // [s]
};

// A velocity in degrees per second would make all of its joint's friction and inertia 57 times too
// large.
TEST(Watch, DerivesAnInconsistentVelocityFromThePosition) {
  Recording recording = with_change("payload:tool:mass=0.3", 16.0, 1);
  recording.dq.col(1) *= 180.0 / M_PI;
  Watch watch(bench().arm);
  std::vector<WatchEvent> events = watch.add(recording);
  for (const WatchEvent& e : watch.finish()) events.push_back(e);
  ASSERT_EQ(watch.remarks().size(), 1U);
  EXPECT_EQ(watch.remarks()[0].substr(0, 4), "dq2 ");
  const WatchEvent* named = first(events, WatchStage::kNamed);
  ASSERT_NE(named, nullptr) << all_of(events);
  EXPECT_EQ(named->text, "payload:tool") << all_of(events);
  EXPECT_GT(named->time, kChange);
}

TEST(Watch, ReportsAClockThatVelocitiesContradict) {
  Recording slow = recorded({}, 8.0, 1);
  slow.time *= 2.0;
  Watch watch(bench().arm);
  watch.add(slow);
  ASSERT_EQ(watch.remarks().size(), 1U);
  EXPECT_NE(watch.remarks()[0].find("the clock is off, and the true rate is 200 Hz rather than 100 Hz"), std::string::npos) << watch.remarks()[0];
}

// Velocities in another unit contradict the positions as a wrong clock does; the model is that of the rows' own time.
TEST(Watch, DistinguishesAWrongUnitFromAWrongClock) {
  Recording turns = with_change("payload:tool:mass=0.3", 16.0, 2);
  turns.dq *= 1.7;
  Watch watch(bench().arm);
  watch.add(turns);
  watch.finish();
  ASSERT_EQ(watch.remarks().size(), 1U);
  EXPECT_NE(watch.remarks()[0].find("agrees with the rows' clock"), std::string::npos) << watch.remarks()[0];
  const WatchEvent* named = first(watch.events(), WatchStage::kNamed);
  ASSERT_NE(named, nullptr) << all_of(watch.events());
  EXPECT_EQ(named->text, "payload:tool") << all_of(watch.events());
  EXPECT_NEAR(named->since, kChange, 0.5);
}

// A clock that is wrong from the beginning on is mended: nothing else is seen than on the true one, and times are
// those of the rows.
TEST(Watch, AWrongClockIsNoChange) {
  for (const double factor : {0.5, 1.1, 2.0, 10.0}) {
    Recording quiet = recorded({}, 60.0, 3), changed = with_change("payload:tool:mass=0.3", 16.0, 3);
    for (Recording* r : {&quiet, &changed}) r->time = 7.0 + factor * r->time.array();
    EXPECT_TRUE(watched(quiet).empty()) << factor << "\n" << all_of(watched(quiet));
    const std::vector<WatchEvent> events = watched(changed);
    const WatchEvent* named = first(events, WatchStage::kNamed);
    ASSERT_NE(named, nullptr) << factor << "\n" << all_of(events);
    EXPECT_EQ(named->text, "payload:tool") << all_of(events);
    EXPECT_NEAR(named->since, 7.0 + factor * kChange, 0.5 * factor) << all_of(events);
    EXPECT_NE(named->sentence.find(fmt::format("since {:.2f} s", named->since)), std::string::npos) << named->sentence;
    EXPECT_NEAR(named->value, 0.3, 0.03) << all_of(events);
  }
}

// One that goes wrong while the arm is watched takes the sight, and is no change; once it is right again, changes are seen.
TEST(Watch, AClockThatGoesWrongIsReportedAndNoChange) {
  for (const double factor : {0.5, 1.2, 2.0}) {
    Recording r = joined(recorded({}, 50.0, 4), recorded({"payload:tool:mass=0.3"}, 50.0, 4), 30.0, 50.0);
    const double begin = 10.0, end = 20.0;
    for (double& t : r.time) t = t < begin ? t : t < end ? begin + factor * (t - begin) : t + (factor - 1.0) * (end - begin);
    const double shift = (factor - 1.0) * (end - begin);
    const std::vector<WatchEvent> events = watched(r);
    int blind = 0;
    for (const WatchEvent& e : events) {
      blind += e.stage == WatchStage::kBlind ? 1 : 0;
      EXPECT_TRUE(e.stage == WatchStage::kBlind || e.stage == WatchStage::kSuspected || e.time > 30.0 + shift) << factor << "\n" << all_of(events);
    }
    ASSERT_EQ(blind, 1) << factor << "\n" << all_of(events);
    const WatchEvent* lost = first(events, WatchStage::kBlind);
    EXPECT_NEAR(lost->since, begin, 0.4) << all_of(events);
    EXPECT_NE(lost->sentence.find(factor > 1.0 ? "as by a clock that is too fast" : "as by a clock that is too slow"), std::string::npos) << lost->sentence;
    const WatchEvent* named = first(events, WatchStage::kNamed);
    ASSERT_NE(named, nullptr) << factor << "\n" << all_of(events);
    EXPECT_EQ(named->text, "payload:tool") << all_of(events);
  }
}

// Rows come at 200 Hz, and some of their signals have a new value at 20 Hz only: that is no push, and a load is
// still seen.
TEST(Watch, ASlowlyRefreshedSignalIsNoChange) {
  struct Slow {
    const char* name;
    bool q, dq, tau, without_velocities;
  };
  for (const Slow& slow : {Slow{"tau", false, false, true, false}, Slow{"tau, no dq", false, false, true, true}, Slow{"q, dq", true, true, false, false},
                           Slow{"q, no dq", true, false, false, true}, Slow{"all", true, true, true, false}}) {
    Recording quiet = recorded({}, 60.0, 5), changed = with_change("payload:tool:mass=0.3", 16.0, 5);
    for (Recording* r : {&quiet, &changed}) {
      for (int k = 0; k < r->rows(); ++k) {
        const auto hold = [k](MatrixXd& m, int phase) { m.row(k) = m.row(std::max(0, k - (k + phase) % 10)).eval(); };
        if (slow.q) hold(r->q, 0);
        if (slow.dq) hold(r->dq, 3);
        if (slow.tau) hold(r->tau, 6);
      }
      if (slow.without_velocities) r->dq.resize(0, 0);
    }
    EXPECT_TRUE(watched(quiet).empty()) << slow.name << "\n" << all_of(watched(quiet));
    const std::vector<WatchEvent> events = watched(changed);
    const WatchEvent* named = first(events, WatchStage::kNamed);
    ASSERT_NE(named, nullptr) << slow.name << "\n" << all_of(events);
    EXPECT_EQ(named->text, "payload:tool") << slow.name << "\n" << all_of(events);
  }
}

class Change : public testing::TestWithParam<Case> {};

// What was put in at 5 s is seen within a second and has its own name and size some seconds later;
// nothing else is told.
TEST_P(Change, IsDetectedAndNamed) {
  const Case& c = GetParam();
  for (const unsigned seed : {1U, 2U}) {
    const std::vector<WatchEvent> events = watched(with_change(c.hidden, 16.0, seed));
    ASSERT_FALSE(events.empty());
    EXPECT_LT(events.front().time - kChange, c.latest_alarm) << all_of(events);
    EXPECT_GT(events.front().time, kChange) << all_of(events);
    const WatchEvent* named = first(events, WatchStage::kNamed);
    ASSERT_NE(named, nullptr) << all_of(events);
    EXPECT_EQ(named->text, c.cause) << all_of(events);
    EXPECT_LT(named->time - kChange, c.latest_name) << all_of(events);
    EXPECT_NEAR(named->since, kChange, 0.5) << all_of(events);
    EXPECT_LT(named->low, c.size) << all_of(events);
    EXPECT_GT(named->high, c.size) << all_of(events);
    EXPECT_EQ(events.back().id, 1) << all_of(events);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Watch, Change,
    testing::Values(
        Case{"payload", "payload:tool:mass=0.3", "payload:tool", 0.3, 1.0, 6.0},
        Case{"friction", "coulomb_friction:pitch:level=0.3", "coulomb_friction:pitch", 0.3, 1.0, 6.0},
        Case{"offset", "torque_offset:yaw:offset=0.2", "torque_offset:yaw", 0.2, 1.0, 6.0},
        Case{"slip", "encoder_offset:pitch:offset=0.02", "encoder_offset:pitch", 0.02, 0.3, 0.3},
        Case{"gain", "torque_gain:pitch:gain=1.3", "torque_gain:pitch", 0.3, 1.5, 6.0}),
    [](const auto& one) { return std::string(one.param.name); });

// A push that ends is told as over, with its time, and leaves nothing behind.
TEST(Watch, APushIsReported) {
  const std::vector<WatchEvent> events =
      watched(recorded({"external_contact:pitch:from=6,to=6.8,effort=1"}, 16.0, 1));
  const WatchEvent* over = first(events, WatchStage::kOver);
  ASSERT_NE(over, nullptr) << all_of(events);
  EXPECT_TRUE(std::holds_alternative<ExternalContact>(over->cause)) << all_of(events);
  EXPECT_EQ(joint_of(over->cause)->value, 1);
  EXPECT_NEAR(over->since, 6.0, 0.3);
  EXPECT_NEAR(over->until, 6.8, 0.3);
  EXPECT_EQ(events.back().id, 1) << all_of(events);
}

// Torques that come 40 ms late from 5 s on are on no list of this arm.
TEST(Watch, WhatNoCauseExplainsHasNoName) {
  const Recording quiet = recorded({}, 20.0, 1);
  Recording late = quiet;
  const auto from = static_cast<Eigen::Index>(kChange * WatchedArm::kRate);
  late.tau.bottomRows(late.rows() - from) = quiet.tau.middleRows(from - 8, quiet.rows() - from);
  const std::vector<WatchEvent> events = watched(late);
  ASSERT_FALSE(events.empty());
  for (const WatchEvent& e : events) {
    EXPECT_TRUE(e.stage != WatchStage::kNamed && e.stage != WatchStage::kRefined) << all_of(events);
    EXPECT_TRUE(e.stage != WatchStage::kUnnamed || e.sentence.find("or a change that is not on the list") != std::string::npos) << e.sentence;
  }
  EXPECT_NE(first(events, WatchStage::kUnnamed), nullptr) << all_of(events);
}

// Columns of two joints are exchanged from the first row on: no single cause explains it.
TEST(Watch, ABeginningThatNoCauseExplainsHasNoName) {
  Recording exchanged = recorded({}, 16.0, 1);
  exchanged.tau.col(0).swap(exchanged.tau.col(1));
  EXPECT_EQ(first(watched(exchanged), WatchStage::kPresent), nullptr) << all_of(watched(exchanged));
}

// A torque offset of pitch at onsets every half second of two motions: named within 3 s, and every
// name that is wrong at first is withdrawn.
TEST(Watch, ACauseIsNamedAtAnyOnset) {
  int right = 0;
  int withdrawn = 0;
  for (const double period : {0.0, 10.0}) {
    const MotionSamples motion = watched_waves(36.0, period);
    const Recording before = bench().recorded(motion, {}, 1);
    const Recording after = bench().recorded(motion, {"torque_offset:pitch:offset=0.3"}, 1);
    for (double onset = 5.0; onset < (period > 0.0 ? 15.0 : 30.0); onset += 0.5) {
      const std::vector<WatchEvent> events = watched(joined(before, after, onset, onset + 6.0));
      const OnsetAnswer a = answer(events, onset, "torque_offset:pitch", 0.3);
      right += a.right ? 1 : 0;
      withdrawn += first(events, WatchStage::kWithdrawn) != nullptr ? 1 : 0;
      EXPECT_FALSE(a.impossible) << a.events;
      EXPECT_EQ(a.changes, 1) << onset << ":\n" << a.events;
      ASSERT_FALSE(events.empty()) << onset;
      EXPECT_EQ(events.back().text, "torque_offset:pitch") << onset << ":\n" << a.events;
    }
  }
  EXPECT_GE(right, 69);  // of 70
  EXPECT_GE(withdrawn, 1);
}

// After a pause, memories fill for a second before there is an alarm.
TEST(Watch, NoAlarmWithinASecondAfterAPause) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    Recording r = with_change("payload:tool:mass=0.3", 16.0, seed);
    r.time.tail(r.rows() - static_cast<int>(kChange * WatchedArm::kRate)).array() += 4.0;
    const std::vector<WatchEvent> events = watched(r);
    ASSERT_GT(events.size(), 1U);
    EXPECT_EQ(events[0].stage, WatchStage::kBlind) << all_of(events);
    EXPECT_GE(events[1].time, kChange + 4.0 + 1.0) << all_of(events);
    EXPECT_LT(events[1].time, kChange + 4.0 + 2.0) << all_of(events);
  }
}

// Numbers reach every part: without consecutive steps enough there is no alarm, no row before the time step is known.
TEST(Watch, UsesGivenThresholds) {
  const Recording recording = with_change("payload:tool:mass=0.3", 16.0, 1);
  const auto events = [&recording](const WatchNumbers& numbers) {
    Watch watch(bench().arm, {}, numbers);
    watch.add(recording);
    watch.finish();
    return watch.events();
  };
  WatchNumbers patient, mistrusting;
  patient.above_in_a_row = 1000000;
  mistrusting.rows_for_step = 1000000;
  EXPECT_FALSE(events(WatchNumbers()).empty());
  EXPECT_TRUE(events(patient).empty());
  EXPECT_TRUE(events(mistrusting).empty());
}

// A change that the watch finds when it begins is told, and is no alarm.
TEST(Watch, AnInitialDifferenceIsReported) {
  struct There {
    const char* hidden;
    const char* cause;
    double size;
  };
  for (const There& there : {There{"torque_offset:pitch:offset=0.3", "torque_offset:pitch", 0.3},
                             There{"payload:tool:mass=0.3", "payload:tool", 0.3}}) {
    const std::vector<WatchEvent> events = watched(recorded({there.hidden}, 20.0, 1));
    ASSERT_EQ(events.size(), 1U) << all_of(events);
    EXPECT_EQ(events[0].stage, WatchStage::kPresent);
    EXPECT_EQ(events[0].text, there.cause) << all_of(events);
    EXPECT_LT(events[0].low, there.size) << all_of(events);
    EXPECT_GT(events[0].high, there.size) << all_of(events);
  }
}

// Eight minutes with other noise each, and a model that is right.
TEST(Watch, AQuietArmGivesNoAlarm) {
  for (const unsigned seed : {11U, 12U, 13U, 14U}) {
    const std::vector<WatchEvent> events = watched(recorded({}, 120.0, seed));
    EXPECT_TRUE(events.empty()) << all_of(events);
  }
}

TEST(Watch, BadInputIsRefused) {
  WatchOptions options;
  options.links = {"tol"};
  EXPECT_THROW(Watch(bench().arm, options), InvalidInput);
  EXPECT_THROW(Watch(read_model("psm-3dof")), InvalidInput);  // bodies without values
  const double inf = std::numeric_limits<double>::infinity();
  const auto refused = [](const std::function<void(WatchOptions&)>& change) {
    WatchOptions changed;
    change(changed);
    EXPECT_THROW(Watch(bench().arm, changed), InvalidInput);
  };
  for (const double value : {0.0, -1.0, std::nan(""), inf}) {
    refused([value](WatchOptions& o) { o.learn = value; });
    refused([value](WatchOptions& o) { o.learn_more = value; });
    refused([value](WatchOptions& o) { o.step = value; });
    refused([value](WatchOptions& o) { o.false_alarms = value; });
    refused([value](WatchOptions& o) { o.longest_naming = value; });
    if (value != 0.0) refused([value](WatchOptions& o) { o.refine = value; });
  }
  refused([](WatchOptions& o) { o.learn_more = 0.5 * o.learn; });
  refused([](WatchOptions& o) { o.step = WatchNumbers().short_memory; });  // which would forget everything
  Watch watch(bench().arm);
  Recording two;
  two.time = VectorXd::LinSpaced(50, 0.0, 1.0);
  two.q = two.tau = MatrixXd::Zero(50, 2);
  EXPECT_THROW(watch.add(two), InvalidInput);
  Recording frozen = recorded({}, 10.0, 1);
  frozen.time.setConstant(3.0);
  Watch without_clock(bench().arm);
  without_clock.add(frozen);
  EXPECT_TRUE(refuses_with("times that do not rise", [&] { without_clock.finish(); }));
}

// Rows without velocities after rows with them: before the velocities are judged, and long afterwards.
TEST(Watch, RefusesRowsThatLackVelocities) {
  Recording later = recorded({}, 1.0, 1);
  later.dq.resize(0, 0);
  for (const double seconds : {0.5, 6.0}) {
    Watch watch(bench().arm);
    watch.add(recorded({}, seconds, 1));
    EXPECT_TRUE(refuses_with(seconds < 1.0 ? "columns dq" : "no velocities", [&] { watch.add(later); })) << seconds;
  }
}

// What takes the sight from a watch is said, with the time that is lost; it is no change, and nothing is
// made of what was suspected in it: a torque that is no number or stops, a recorder that repeats its last
// row, no rows at all, few rows, a clock that stands still or begins again.
TEST(Watch, ReportsUnusableIntervals) {
  const int from = 10 * static_cast<int>(WatchedArm::kRate);
  const Recording quiet = recorded({}, 20.0, 6);
  const int last = quiet.rows() - from;
  Recording nothing = quiet;
  nothing.tau.col(1).tail(last).setConstant(std::numeric_limits<double>::quiet_NaN());
  Recording dead = quiet;
  dead.tau.col(1).tail(last).setZero();
  Recording frozen = quiet;
  for (MatrixXd* m : {&frozen.q, &frozen.dq, &frozen.tau}) m->bottomRows(last).rowwise() = m->row(from).eval();
  Recording pause = quiet;
  pause.time.tail(last).array() += 10.0;
  Recording stopped = quiet;
  stopped.time.tail(last).setConstant(quiet.time[from - 1]);
  Recording restarted = quiet;
  restarted.time.tail(last).array() -= 10.0;
  Recording sparse = rows_of(quiet, 0, from);  // one row of sixteen
  for (int k = from; k < quiet.rows(); k += 16) append(sparse, rows_of(quiet, k, 1));
  struct Blinder {
    Recording rows;
    const char* why;
    double blind;  // [s]
  };
  const Blinder all[] = {{nothing, "tau2 (pitch) is no number", 10.0},
                      {dead, "tau2 (pitch) stays at 0", 10.0},
                      {frozen, "the same row", 10.0},
                      {pause, "no usable row", 10.0},
                      {stopped, "times do not rise", 10.0},
                      {sparse, "rows come every 80 ms, and every 5 ms before", 10.0},
                      {restarted, "the clock was set back to 0 s, and the watch begins anew", 0.25}};
  for (const auto& [rows, why, seconds] : all) {
    Watch watch(bench().arm);
    std::vector<WatchEvent> events = watch.add(rows);
    for (const WatchEvent& e : watch.finish()) events.push_back(e);
    int blind = 0;
    for (const WatchEvent& e : events) {
      EXPECT_TRUE(e.stage == WatchStage::kBlind || e.stage == WatchStage::kSuspected) << all_of(events);
      if (e.stage != WatchStage::kBlind) continue;
      ++blind;
      EXPECT_NEAR(e.since, 10.0, 0.1) << all_of(events);
      EXPECT_NE(e.sentence.find(why), std::string::npos) << all_of(events);
    }
    EXPECT_EQ(blind, 1) << why << "\n" << all_of(events);
    ASSERT_FALSE(events.empty());
    EXPECT_EQ(events.back().stage, WatchStage::kBlind) << all_of(events);
    EXPECT_NEAR(watch.state().blind, seconds, 0.02 * seconds + 0.01) << why;
  }
}

// Gaps, numbers that are none and repeated rows are passed over; a pause joins nothing.
TEST(Watch, BadRowsRaiseNoAlarmAndAPauseIsReported) {
  Recording r = recorded({}, 20.0, 5);
  r.tau.row(1000).setConstant(std::numeric_limits<double>::quiet_NaN());
  r.q(1500, 1) = std::numeric_limits<double>::infinity();
  r.q.row(2001) = r.q.row(2000);
  r.dq.row(2001) = r.dq.row(2000);
  r.tau.row(2001) = r.tau.row(2000);
  r.time.tail(1000).array() += 3.0;
  const std::vector<WatchEvent> events = watched(r);
  ASSERT_EQ(events.size(), 1U) << all_of(events);
  EXPECT_EQ(events[0].stage, WatchStage::kBlind) << all_of(events);
}

// A first row without a time is no reason to wait for the end of the rows.
TEST(Watch, StartsWithARowWithoutATime) {
  Recording r = recorded({}, 6.0, 5);
  r.time[0] = std::numeric_limits<double>::quiet_NaN();
  Watch watch(bench().arm);
  watch.add(r);
  EXPECT_FALSE(watch.state().learning);
  EXPECT_GT(watch.state().time, 5.5);
}

// A link that is given twice is one, and no rival of itself.
TEST(Watch, CountsADuplicateLinkOnce) {
  WatchOptions options;
  options.links = {"tool", "tool"};
  Watch watch(bench().arm, options);
  watch.add(with_change("payload:tool:mass=0.3", 16.0, 1));
  watch.finish();
  const WatchEvent* named = first(watch.events(), WatchStage::kNamed);
  ASSERT_NE(named, nullptr) << all_of(watch.events());
  EXPECT_EQ(named->text, "payload:tool");
  for (const WatchRival& rival : named->rivals) EXPECT_NE(rival.text, named->text);
}

TEST(Watch, PrintsEffectsAsWords) {
  WatchEvent e;
  e.stage = WatchStage::kRefined;
  e.cause = NewEffect{"coulomb_friction", {0}};
  e.text = "coulomb_friction:yaw";
  e.unit = "N m";
  EXPECT_NE(watching::sentence(e).find("Coulomb friction of joint 1 (yaw) differs by"), std::string::npos)
      << watching::sentence(e);
}

}  // namespace
}  // namespace veridyn
