#include "recordings/prepared_recording.hpp"

#include <gtest/gtest.h>

#include <memory>

#include "cli/tool.hpp"
#include "recordings/kept_recordings.hpp"
#include "recordings/velocity_trust.hpp"
#include "simulation/simulation_support.hpp"

// What is prepared once is what streaming gives, for every setting that changes it.

namespace veridyn {
namespace {

Recording moving(const MotionSamples& m) {
  Recording r;
  r.time = m.time;
  r.q = m.q;
  r.dq = m.dq;
  r.tau = m.ddq;
  return r;
}

std::vector<Segment> visited(const Model& arm, const std::string& path, const PreprocessingOptions& how) {
  std::vector<Segment> out;
  for_each_segment(arm, path, how, [&out](const Segment& s) { out.push_back(s); });
  return out;
}

class Prepared : public testing::Test {
 protected:
  Prepared() : path_(folder_.path("r.csv")) { write_recording(moving(waves(2, 0.5)), path_); }

  TemporaryFolder folder_;
  std::string path_;
  Model arm_ = read_model("planar-2r");
};

TEST_F(Prepared, KeptSegmentsEqualStreamedOnesAndArePreparedOnce) {
  PreprocessingOptions kept;
  kept.kept = std::make_shared<KeptRecordings>();
  const std::vector<Segment> streamed = visited(arm_, path_, {});
  const long before = recordings_prepared();
  for (int turn = 0; turn < 3; ++turn) {
    const std::vector<Segment> again = visited(arm_, path_, kept);
    ASSERT_EQ(again.size(), streamed.size());
    for (size_t k = 0; k < again.size(); ++k) {
      EXPECT_EQ(again[k].q, streamed[k].q);
      EXPECT_EQ(again[k].ddq, streamed[k].ddq);
      EXPECT_EQ(again[k].tau, streamed[k].tau);
      EXPECT_EQ(again[k].use, streamed[k].use);
    }
  }
  EXPECT_EQ(recordings_prepared() - before, 1);
}

// Whatever changes a segment makes it be prepared anew, and what does not, does not.
TEST_F(Prepared, AChangedSettingPreparesTheRecordingAgain) {
  PreprocessingOptions how;
  how.kept = std::make_shared<KeptRecordings>();
  visited(arm_, path_, how);
  const auto prepared = [&](const Model& arm, const PreprocessingOptions& other) {
    const long before = recordings_prepared();
    visited(arm, path_, other);
    return recordings_prepared() - before;
  };
  const auto with = [&how](auto change) {
    PreprocessingOptions other = how;
    change(other);
    return other;
  };
  EXPECT_EQ(prepared(arm_, with([](auto& o) { o.cutoff = 7.0; })), 1);
  EXPECT_EQ(prepared(arm_, with([](auto& o) { o.order = 4; })), 1);
  EXPECT_EQ(prepared(arm_, with([](auto& o) { o.filtering = Filtering::kSignals; })), 1);
  EXPECT_EQ(prepared(arm_, with([](auto& o) { o.signal_cutoff_ratio = 2.0; })), 1);
  EXPECT_EQ(prepared(arm_, with([](auto& o) { o.velocity = VelocitySource::kDerived; })), 1);
  EXPECT_EQ(prepared(arm_, with([](auto& o) { o.derive_velocity_of = {{1}}; })), 1);
  EXPECT_EQ(prepared(arm_, with([](auto& o) { o.stale_rows = StaleRows::kKept; })), 1);
  EXPECT_EQ(prepared(arm_, with([](auto& o) { o.rate = 50.0; })), 1);
  EXPECT_EQ(prepared(arm_, with([](auto& o) { o.drop_start = 2.0; })), 1);
  EXPECT_EQ(prepared(arm_, with([](auto& o) { o.drop_end = 2.0; })), 1);
  EXPECT_EQ(prepared(arm_, with([](auto& o) { o.first_row = 50; })), 1);
  EXPECT_EQ(prepared(arm_, with([](auto& o) { o.row_count = 400; })), 1);
  ModelDescription shown = arm_.description();
  shown.coordinates[1].recorded.torque_gain = 1.2;
  EXPECT_EQ(prepared(Model(shown), how), 1);
  EXPECT_EQ(prepared(arm_, with([this](auto& o) { o.excluded_intervals.push_back({path_, {}, 1.0, 2.0, ""}); })), 0);
  EXPECT_EQ(prepared(arm_, with([](auto& o) { o.min_speed = 0.1; })), 0);
  EXPECT_EQ(prepared(arm_, how), 0);
}

TEST_F(Prepared, ARecordingBeyondTheMemoryBoundIsPreparedInEveryPass) {
  PreprocessingOptions small;
  small.kept = std::make_shared<KeptRecordings>(10);
  const long before = recordings_prepared();
  visited(arm_, path_, small);
  visited(arm_, path_, small);
  EXPECT_EQ(recordings_prepared() - before, 2);
  PreprocessingOptions how;
  how.kept = std::make_shared<KeptRecordings>();
  how.interrupted = [] { return true; };
  EXPECT_THROW(visited(arm_, path_, how), Interrupted);
  how.interrupted = {};
  EXPECT_FALSE(visited(arm_, path_, how).empty());
}

TEST(VelocityTrust, AWrongVelocityIsNotListedAsDoubtfulToo) {
  RecordingQuality quality;
  const auto add = [&quality](QualityKind kind, JointIndex joint, Severity severity) {
    QualityFinding f;
    f.kind = kind;
    f.joint = joint;
    f.severity = severity;
    quality.findings.push_back(f);
  };
  add(QualityKind::kVelocityScale, {0}, Severity::kWarning);
  add(QualityKind::kVelocityNoise, {0}, Severity::kInfo);
  add(QualityKind::kVelocityNoise, {1}, Severity::kInfo);
  add(QualityKind::kVelocityQuantised, {2}, Severity::kInfo);  // right on average
  add(QualityKind::kVelocityDelay, {3}, Severity::kWarning);
  add(QualityKind::kSaturation, {4}, Severity::kFault);
  const VelocityTrust trust = trust_in_velocities({quality});
  EXPECT_EQ(trust.wrong, (std::set<JointIndex>{{0}, {3}}));
  EXPECT_EQ(trust.doubtful, (std::set<JointIndex>{{1}}));
}

}  // namespace
}  // namespace veridyn
