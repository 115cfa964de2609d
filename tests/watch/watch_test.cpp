#include "veridyn/watch/watch.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "veridyn/math/require.hpp"
#include "veridyn/model/model_file.hpp"
#include "veridyn/simulation/plausible_model.hpp"
#include "veridyn/simulation/simulate_recording.hpp"
#include "support/simulated.hpp"
#include "watch/event_words.hpp"

namespace veridyn {
namespace {

constexpr double kRate = 200.0;   // [Hz]
constexpr double kChange = 5.0;   // [s]

const Model& arm() {
  static const Model kArm = plausible_model(read_model("psm-3dof"), 3).arm;
  return kArm;
}

// Slow waves of all joints whose periods have no common multiple within the recording.
MotionSamples waves(double seconds) {
  const auto rows = static_cast<Eigen::Index>(seconds * kRate);
  MotionSamples m;
  m.time = VectorXd::LinSpaced(rows, 0.0, (static_cast<double>(rows) - 1.0) / kRate);
  m.q = m.dq = m.ddq = MatrixXd::Zero(rows, 3);
  const double middle[] = {0.0, 0.0, 0.12};
  const double size[] = {0.6, 0.5, 0.05};
  const double pace[] = {2.1, 1.7, 1.3};  // [rad/s]
  for (int j = 0; j < 3; ++j) {
    for (const double overtone : {1.0, 2.3}) {
      const double w = pace[j] * overtone;
      const double a = size[j] / (2.0 * overtone);
      m.q.col(j).array() += a * (w * m.time.array() + j).sin();
      m.dq.col(j).array() += a * w * (w * m.time.array() + j).cos();
      m.ddq.col(j).array() -= a * w * w * (w * m.time.array() + j).sin();
    }
    m.q.col(j).array() += middle[j];
  }
  return m;
}

Recording recorded(const std::vector<std::string>& hidden, double seconds, unsigned seed) {
  SimulationOptions options;
  for (const std::string& one : hidden) options.hidden.push_back(parse_hidden_effect(one));
  options.noise = sensor_noise("low");
  options.seed = seed;
  return recording_of(simulate_recording(arm(), waves(seconds), options));
}

// The arm as it is, and from kChange on with something hidden in it.
Recording with_change(const std::string& hidden, double seconds, unsigned seed) {
  Recording out = recorded({}, seconds, seed);
  const Recording after = recorded({hidden}, seconds, seed);
  const auto from = static_cast<Eigen::Index>(kChange * kRate);
  const Eigen::Index rows = out.rows() - from;
  for (const RecordingSignal& signal : kRecordingSignals) {
    MatrixXd& values = out.*signal.values;
    if (values.size() > 0) values.bottomRows(rows) = (after.*signal.values).bottomRows(rows);
  }
  return out;
}

std::vector<WatchEvent> watched(const Recording& recording) {
  Watch watch(arm());
  for (int k = 0; k < recording.rows(); k += 37)  // in pieces of any size
    watch.add(rows_of(recording, k, std::min(37, recording.rows() - k)));
  watch.finish();
  return watch.events();
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

class Change : public testing::TestWithParam<Case> {};

// What was put in at 5 s is seen within a second and has its own name and size some seconds later;
// nothing else is told.
TEST_P(Change, IsSeenAndNamed) {
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
TEST(Watch, APushIsTold) {
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
  EXPECT_THROW(Watch(arm(), options), InvalidInput);
  EXPECT_THROW(Watch(read_model("psm-3dof")), InvalidInput);  // bodies without values
  Watch watch(arm());
  Recording two;
  two.time = VectorXd::LinSpaced(50, 0.0, 1.0);
  two.q = two.tau = MatrixXd::Zero(50, 2);
  EXPECT_THROW(watch.add(two), InvalidInput);
}

// Gaps, numbers that are none and repeated rows are passed over; a pause joins nothing.
TEST(Watch, SurvivesBadRows) {
  Recording r = recorded({}, 20.0, 5);
  r.tau.row(1000).setConstant(std::numeric_limits<double>::quiet_NaN());
  r.q(1500, 1) = std::numeric_limits<double>::infinity();
  r.q.row(2001) = r.q.row(2000);
  r.dq.row(2001) = r.dq.row(2000);
  r.tau.row(2001) = r.tau.row(2000);
  r.time.tail(1000).array() += 3.0;
  const std::vector<WatchEvent> events = watched(r);
  EXPECT_TRUE(events.empty()) << all_of(events);
}

TEST(Watch, SpeaksOfEffectsInWords) {
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
