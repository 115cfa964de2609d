#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "recordings/bags/bag_sink.hpp"
#include "recordings/files/byte_reader.hpp"
#include "recordings/bags/inflate.hpp"
#include "recordings/bags/message_decoder.hpp"
#include "recordings/bags/topic_decoder.hpp"
#include "recordings/samples.hpp"

namespace veridyn::bags {
namespace {

using Numbers = std::map<std::string, std::vector<double>>;
using Texts = std::map<std::string, std::vector<std::string>>;

// All values of a message by path.
class Values : public ValueSink {
 public:
  explicit Values(const MessagePlan& plan) : plan_(plan) {}
  void number(int leaf, double value) override { numbers[path(leaf)].push_back(value); }
  void text(int leaf, std::string_view value) override { texts[path(leaf)].emplace_back(value); }
  void time(int leaf, std::int64_t value) override { times[path(leaf)] = value; }

  Numbers numbers;
  Texts texts;
  std::map<std::string, std::int64_t> times;

 private:
  const std::string& path(int leaf) const { return plan_.paths[leaf]; }
  const MessagePlan& plan_;
};

struct Decoded {
  Numbers numbers;
  Texts texts;
  std::map<std::string, std::int64_t> times;
};

Decoded decode(const std::string& file, const std::string& type) {
  const bool ros2 = file.rfind("cdr_", 0) == 0;
  const MessagePlan plan = plan_of(type, "", ros2);
  const std::string bytes = bytes_of_file(sample("vectors/" + file));
  EXPECT_FALSE(bytes.empty()) << file;
  Values values(plan);
  ros2 ? decode_cdr(plan, bytes, &values) : decode_ros1(plan, bytes, &values);
  return {values.numbers, values.texts, values.times};
}

constexpr std::int64_t kStamp = 1700000000250000000;

class InEitherSerialisation : public testing::TestWithParam<std::string> {
 protected:
  Decoded read(const std::string& name, const std::string& type) const {
    return decode(GetParam() + "_" + name + ".bin", type);
  }
};

INSTANTIATE_TEST_SUITE_P(Messages, InEitherSerialisation, testing::Values("ros1", "cdr"),
                         [](const auto& one) { return one.param; });

TEST_P(InEitherSerialisation, AJointStateHasItsValues) {
  const Decoded m = read("JointState", "sensor_msgs/JointState");
  EXPECT_EQ(m.times.at("header/stamp"), kStamp);
  EXPECT_EQ(m.texts.at("header/frame_id").front(), "base");
  EXPECT_EQ(m.texts.at("name"), (std::vector<std::string>{"a", "bb", "ccc"}));
  EXPECT_EQ(m.numbers.at("position"), (std::vector<double>{1, -2, 0.5}));
  EXPECT_EQ(m.numbers.at("velocity"), (std::vector<double>{0.25, 0, -1}));
  EXPECT_EQ(m.numbers.at("effort"), (std::vector<double>{10, 20, 30}));
}

TEST_P(InEitherSerialisation, EmptyArraysGiveNoSignal) {
  const Decoded m = read("JointStatePosOnly", "sensor_msgs/msg/JointState");
  EXPECT_EQ(m.texts.at("header/frame_id").front(), "");
  EXPECT_EQ(m.numbers.at("position"), (std::vector<double>{1, -2}));
  EXPECT_EQ(m.numbers.count("velocity"), 0u);
  EXPECT_EQ(m.numbers.count("effort"), 0u);
}

TEST_P(InEitherSerialisation, StampedGeometryHasItsValues) {
  const Decoded wrench = read("WrenchStamped", "geometry_msgs/WrenchStamped");
  EXPECT_EQ(wrench.numbers.at("wrench/force/x").front(), 1.0);
  EXPECT_EQ(wrench.numbers.at("wrench/torque/z").front(), 6.0);
  EXPECT_EQ(wrench.texts.at("header/frame_id").front(), "tool0");
  const Decoded twist = read("TwistStamped", "geometry_msgs/TwistStamped");
  EXPECT_EQ(twist.numbers.at("twist/angular/y").front(), 5.0);
  const Decoded pose = read("PoseStamped", "geometry_msgs/PoseStamped");
  EXPECT_EQ(pose.numbers.at("pose/position/y").front(), 0.2);
  EXPECT_EQ(pose.numbers.at("pose/orientation/w").front(), 1.0);
  const Decoded frame = read("TransformStamped", "geometry_msgs/TransformStamped");
  EXPECT_EQ(frame.texts.at("child_frame_id").front(), "tool");
  EXPECT_EQ(frame.numbers.at("transform/translation/z").front(), 0.3);
}

TEST_P(InEitherSerialisation, AMultiArrayHasItsLayoutAndData) {
  const Decoded m = read("Float64MultiArray", "std_msgs/Float64MultiArray");
  EXPECT_EQ(m.texts.at("layout/dim/label"), (std::vector<std::string>{"rows", "cols"}));
  EXPECT_EQ(m.numbers.at("layout/dim/stride"), (std::vector<double>{6, 3}));
  EXPECT_EQ(m.numbers.at("data"), (std::vector<double>{1, 2, 3, 4, 5, 6}));
}

TEST_P(InEitherSerialisation, AStringHasItsText) {
  EXPECT_EQ(read("String", "std_msgs/String").texts.at("data").front(), "note 0");
}

TEST(ACdrMessage, OfSmallTypesHasItsValues) {
  EXPECT_EQ(decode("cdr_Bool.bin", "std_msgs/msg/Bool").numbers.at("data").front(), 1.0);
  EXPECT_EQ(decode("cdr_EmptyString.bin", "std_msgs/msg/String").texts.at("data").front(), "");
  const Decoded header = decode("cdr_Header.bin", "std_msgs/msg/Header");
  EXPECT_EQ(header.times.at("stamp"), kStamp);
  EXPECT_EQ(header.texts.at("frame_id").front(), "base");
  const Decoded effort = decode("cdr_JointStateEffOnly.bin", "sensor_msgs/msg/JointState");
  EXPECT_EQ(effort.numbers.at("effort"), std::vector<double>{3.5});
  EXPECT_EQ(effort.texts.count("name"), 0u);
  EXPECT_EQ(decode("cdr_Float64MultiArrayNoDim.bin", "std_msgs/msg/Float64MultiArray")
                .numbers.at("data"),
            std::vector<double>{1.5});
}

// Every prefix of every message ends early, and says so.
TEST(ATruncatedMessage, AtAnyByteIsRefused) {
  for (const char* file : {"ros1_JointState.bin", "cdr_JointState.bin", "cdr_Float64MultiArray.bin"}) {
    const bool ros2 = file[0] == 'c';
    const std::string type =
        std::string(file).find("Joint") != std::string::npos ? "sensor_msgs/JointState" : "std_msgs/Float64MultiArray";
    const MessagePlan plan = plan_of(type, "", ros2);
    const std::string bytes = bytes_of_file(sample(std::string("vectors/") + file));
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      Values values(plan);
      const std::string_view part = std::string_view(bytes).substr(0, size);
      EXPECT_THROW(ros2 ? decode_cdr(plan, part, &values) : decode_ros1(plan, part, &values), CutShort)
          << file << " cut to " << size;
    }
  }
}

TEST(ADefinition, IsReadWithConstantsDefaultsBoundsAndDependencies) {
  const MessagePlan plan = plan_of("my_msgs/msg/Mine",
                                   "# a remark\n"
                                   "int32 LIMIT=3\n"
                                   "string NAME = \"x=y\"\n"
                                   "float64[2] pair\n"
                                   "string<=8 label \"none\"\n"
                                   "Inner[<=4] parts # the parts\n"
                                   "================================================================================\n"
                                   "MSG: my_msgs/Inner\n"
                                   "bool on true\n"
                                   "std_msgs/Header header\n",
                                   true);
  EXPECT_EQ(plan.paths, (std::vector<std::string>{"pair", "label", "parts/on", "parts/header/stamp",
                                                  "parts/header/frame_id"}));
}

TEST(ADefinition, ThatIsRecursiveOrIncompleteIsRefused) {
  EXPECT_ANY_THROW(plan_of("a/B", "B[] again\n", false));
  EXPECT_ANY_THROW(plan_of("a/B", "Unknown it\n", false));
}

// The frames of roslz4's own writer.
// Leaves are counted by the plan and known by their names.
TEST(ADefinition, WithTwoFieldsOfOneNameIsNotDecoded) {
  TopicDecoder twice({"/t", "a/B", "ros1", "float64 position\nfloat64 position\n", ""}, true);
  EXPECT_NE(twice.problem().find("two fields one name"), std::string::npos);
  TopicDecoder once({"/t", "a/B", "ros1", "float64 position\nfloat64 velocity\n", ""}, true);
  EXPECT_EQ(once.problem(), "");
}

TEST(AnLz4Frame, IsDecompressedUpToTheGivenSize) {
  const Inflated repeated = inflate("lz4", bytes_of_file(sample("vectors/roslz4_abcd10.lz4")), 1000);
  EXPECT_TRUE(repeated.whole);
  EXPECT_EQ(repeated.bytes, "abcdabcdabcdabcdabcdabcdabcdabcdabcdabcd");
  const Inflated stored =
      inflate("lz4", bytes_of_file(sample("vectors/roslz4_incompressible.lz4")), 1000);
  EXPECT_TRUE(stored.whole);
  ASSERT_EQ(stored.bytes.size(), 9u);
  for (int k = 0; k < 9; ++k) EXPECT_EQ(stored.bytes[k], k);
  EXPECT_FALSE(inflate("lz4", bytes_of_file(sample("vectors/roslz4_abcd10.lz4")), 39).whole);
}

struct Heard {
  std::vector<Channel> channels;
  std::vector<std::pair<std::int64_t, std::string>> messages;
  std::vector<std::string> remarks;
};

Heard hear(const std::string& file) {
  Heard heard;
  BagSink sink;
  sink.open = [&](const Channel& c) {
    heard.channels.push_back(c);
    return static_cast<int>(heard.channels.size()) - 1;
  };
  sink.message = [&](int, std::int64_t t, std::string_view bytes) {
    heard.messages.emplace_back(t, bytes);
  };
  read_bag(sample("vectors/" + file), &sink);
  heard.remarks = sink.remarks;
  return heard;
}

TEST(ASmallContainer, IsReadWithItsChannelAndItsMessage) {
  const Heard bag = hear("mini_ros1.bag");
  ASSERT_EQ(bag.channels.size(), 1u);
  EXPECT_EQ(bag.channels[0].topic, "/a");
  EXPECT_EQ(bag.channels[0].type, "std_msgs/Float64");
  EXPECT_EQ(bag.channels[0].definition, "float64 data\n");
  ASSERT_EQ(bag.messages.size(), 1u);
  EXPECT_EQ(bag.messages[0].first, 10000000020);
  for (const char* file : {"mini_unchunked.mcap", "mini_chunk_zstd.mcap"}) {
    const Heard mcap = hear(file);
    ASSERT_EQ(mcap.channels.size(), 1u) << file;
    EXPECT_EQ(mcap.channels[0].topic, "/j");
    EXPECT_EQ(mcap.channels[0].encoding, "json");
    ASSERT_EQ(mcap.messages.size(), 1u);
    EXPECT_EQ(mcap.messages[0].first, 1000000002);
    EXPECT_EQ(mcap.messages[0].second, "{\"q\":[1,2]}");
    EXPECT_TRUE(mcap.remarks.empty());
  }
}

}  // namespace
}  // namespace veridyn::bags
