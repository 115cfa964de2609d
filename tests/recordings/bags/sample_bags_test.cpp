#include <gtest/gtest.h>

#include <cmath>

#include "recordings/samples.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/recordings/recording.hpp"

namespace veridyn {
namespace {

struct Sample {
  const char* file;
  int rows;
  bool cut;  // a remark must say so
};

std::string name_of(const testing::TestParamInfo<Sample>& info) {
  std::string name = info.param.file;
  for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  return name;
}

class OnEverySampleBag : public testing::TestWithParam<Sample> {};

INSTANTIATE_TEST_SUITE_P(
    Bags, OnEverySampleBag,
    testing::Values(Sample{"ros1_none.bag", 200, false}, Sample{"ros1_bz2.bag", 200, false},
                    Sample{"ros1_lz4.bag", 200, false}, Sample{"ros1_crash_none.bag", 162, true},
                    Sample{"ros1_crash_lz4.bag", 163, true},
                    Sample{"mcap_ros1_none.mcap", 200, false},
                    Sample{"mcap_ros1_lz4.mcap", 200, false},
                    Sample{"mcap_cdr_zstd.mcap", 200, false},
                    Sample{"mcap_cdr_lz4.mcap", 200, false},
                    Sample{"mcap_cdr_lz4_linked.mcap", 200, false},
                    Sample{"mcap_cdr_unchunked.mcap", 200, false},
                    Sample{"mcap_cdr_nosummary.mcap", 200, false},
                    Sample{"mcap_cdr_truncated.mcap", 142, true},
                    Sample{"mcap_cdr_unchunked_truncated.mcap", 121, true},
                    Sample{"mcap_json.mcap", 20, false}, Sample{"rb2_humble_split", 200, false},
                    Sample{"rb2_jazzy", 200, false}, Sample{"rb2_jazzy/rb2_jazzy_0.db3", 200, false},
                    Sample{"rb2_zstd_file", 200, false},
                    Sample{"rb2_zstd_file/rb2_zstd_file_0.db3.zstd", 200, false},
                    Sample{"rb2_zstd_message", 100, false},
                    Sample{"rb2_zstd_message/rb2_zstd_message_0.db3", 100, false},
                    Sample{"csv_rostopic_p.csv", 30, false}),
    name_of);

// Every number to the last bit: the containers hold doubles, and nothing is computed with them.
TEST_P(OnEverySampleBag, AllRowsHaveTheirTrueValues) {
  RecordingReader reader(sample(GetParam().file));
  const Recording r = reader.next(1000);
  const RecordingFacts facts = reader.facts();
  ASSERT_EQ(facts.joints, (std::vector<std::string>{"elbow_joint", "shoulder_lift_joint",
                                                    "shoulder_pan_joint"}));
  ASSERT_EQ(r.rows(), GetParam().rows);
  const std::vector<TrueRow> truth = true_rows();
  for (int k = 0; k < r.rows(); ++k) {
    const TrueRow& row = truth[k];
    ASSERT_NEAR(r.time[k], row.stamp, 1e-12) << "row " << k;
    for (int joint = 0; joint < 3; ++joint) {
      ASSERT_EQ(r.q(k, joint), row.position[joint]) << "row " << k;
      ASSERT_EQ(r.dq(k, joint), row.velocity[joint]) << "row " << k;
      ASSERT_EQ(r.tau(k, joint), row.effort[joint]) << "row " << k;
    }
  }
  EXPECT_NEAR(facts.start, 1.7e9, 1e-6);
  EXPECT_EQ(!facts.remarks.empty(), GetParam().cut);
}

TEST_P(OnEverySampleBag, JointsHaveTheRequestedOrder) {
  RecordingOptions options;
  options.signals.joints = {{"shoulder_pan", false}, {"elbow", false}};
  RecordingReader reader(sample(GetParam().file), options);
  const Recording r = reader.next(1);
  const TrueRow first = true_rows().front();
  ASSERT_EQ(r.joints(), 2);
  EXPECT_EQ(r.q(0, 0), first.position[2]);
  EXPECT_EQ(r.q(0, 1), first.position[0]);
  EXPECT_EQ(reader.facts().match(),
            "joints matched: shoulder_pan = shoulder_pan_joint, elbow = elbow_joint");
}

TEST(ABagOfTheCppWriter, IsReadWithoutTopicsInChunksAndWithoutEfforts) {
  const Recording r = read_recording(sample("ros1_cpp_lz4.bag"));
  ASSERT_EQ(r.rows(), 50);
  for (int k = 0; k < 50; ++k) {
    EXPECT_EQ(r.q(k, 0), k / 2.0);
    EXPECT_EQ(r.q(k, 1), k / 4.0);
    EXPECT_EQ(r.q(k, 2), k / 8.0);
    EXPECT_EQ(r.dq(k, 2), 3.0);
  }
  EXPECT_EQ(r.tau.size(), 0);
}

// Two publishers on one topic, a stamp of zero, one that repeats, one message recorded early.
TEST(ABagWithTwoPublishersOnATopic, JointsOfBothPublishersAreSeparate) {
  RecordingOptions options;
  options.signals.joints = {{"a1", false}, {"a2", false}, {"a3", false}};
  RecordingReader reader(sample("ros1_edge.bag"), options);
  const Recording r = reader.next(1000);
  ASSERT_EQ(r.rows(), 50);
  for (int k = 0; k < 50; ++k) {
    EXPECT_EQ(r.q(k, 0), k / 128.0);
    EXPECT_EQ(r.q(k, 1), k / 16.0);
    EXPECT_EQ(r.q(k, 2), -k / 128.0);
    EXPECT_NEAR(r.time[k], 0.01 * k, 1e-12);
  }
  ASSERT_EQ(reader.facts().remarks.size(), 1u);
  EXPECT_NE(reader.facts().remarks[0].find("2 time stamps are missing or repeated"),
            std::string::npos);
}

TEST(ABag, ListsItsTopicsWithRatesAndJoints) {
  const std::vector<TopicFacts> topics =
      RecordingReader(sample("ros1_edge.bag")).facts().topics;
  ASSERT_EQ(topics.size(), 2u);
  EXPECT_EQ(topics[0].name, "/joint_states");
  EXPECT_EQ(topics[0].messages, 75);
  EXPECT_EQ(topics[0].joints,
            (std::vector<std::string>{"a1", "a2", "a3", "finger_joint"}));
  EXPECT_EQ(topics[1].name, "/tool/wrench");
  EXPECT_EQ(topics[1].messages, 10);
  EXPECT_NEAR(topics[1].rate, 20.0, 1e-6);
}

std::string error_of(const std::string& file, const RecordingOptions& options) {
  try {
    RecordingReader reader(sample(file), options);
    return "";
  } catch (const InvalidInput& error) {
    return error.what();
  }
}

TEST(ABag, NamesItsJointsWhereOneIsMissing) {
  RecordingOptions options;
  options.signals.joints = {{"elbow", false}, {"wrist_1", false}};
  const std::string error = error_of("ros1_lz4.bag", options);
  EXPECT_NE(error.find("found joints elbow_joint, shoulder_lift_joint, shoulder_pan_joint on topic "
                       "/joint_states, and none that is wrist_1, expected --map wrist_1=NAME, or "
                       "--fix wrist_1=VALUE"),
            std::string::npos)
      << error;
}

TEST(ABag, NamesItsTopicsWhereOneIsMissing) {
  RecordingOptions options;
  options.signals.topics = {"/joint_state"};
  const std::string error = error_of("ros1_lz4.bag", options);
  EXPECT_NE(error.find("found no topic /joint_state (did you mean '/joint_states'?), expected one "
                       "of: /joint_states, /note"),
            std::string::npos)
      << error;
}

TEST(ABag, AnyNumericFieldCanBeMappedToASignal) {
  RecordingOptions options;
  options.signals.joints = {{"a1", false}, {"a2", false}, {"a3", false}};
  options.signals.map = {{"tau2", "/tool/wrench/wrench/force/z"}};
  const Recording r = read_recording(sample("ros1_edge.bag"), options);
  ASSERT_EQ(r.tau.cols(), 3);
  // Forces k/4 stand at k = 0, 5, ..., and are interpolated between; the wrench has its own stamps.
  EXPECT_NEAR(r.tau(10, 1), 2.5, 1e-12);
  EXPECT_NEAR(r.tau(12, 1), 3.0, 1e-9);
  EXPECT_TRUE(std::isnan(r.tau(10, 0)));
}

}  // namespace
}  // namespace veridyn
