#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <thread>

#include "recordings/arrays/array_recording.hpp"
#include "support/refusal.hpp"
#include "recordings/fields/import.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/recordings/recording.hpp"

// Files that hold a part of the joints, joints that an arm holds still, arrays without a time.

namespace veridyn {
namespace {

constexpr int kRows = 200;

double place(int joint, double t) { return std::sin((1.0 + joint) * t) + 0.1 * joint; }

class Folder {
 public:
  Folder() : at_(testing::TempDir() + "veridyn-joined-" + std::to_string(::getpid())) {
    std::filesystem::create_directories(at_);
  }
  ~Folder() { std::filesystem::remove_all(at_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::string path(const std::string& name) const { return at_ + "/" + name; }
  std::string write(const std::string& name, const std::string& content) const {
    std::ofstream(path(name)) << content;
    return path(name);
  }

 private:
  std::string at_;
};

class Joined : public testing::Test {
 protected:
  // Columns q, dq and tau of one joint under a number, every 1/rate seconds from `start`.
  std::string file(const std::string& name, int joint, int number, double rate = 100.0, double start = 0.0) const {
    const std::string k = std::to_string(number);
    std::string out = "t,q" + k + ",dq" + k + ",tau" + k + "\n";
    for (int r = 0; r < kRows; ++r) {
      const double t = start + r / rate;
      char line[120];
      std::snprintf(line, sizeof line, "%.10g,%.10g,%.10g,%.10g\n", t, place(joint, t), 0.5 * joint, 2.0 * joint + t);
      out += line;
    }
    return folder_.write(name, out);
  }

  static void expect_joints(const Recording& r, const std::vector<int>& joints) {
    ASSERT_EQ(r.joints(), static_cast<int>(joints.size()));
    ASSERT_GT(r.rows(), 10);
    ASSERT_EQ(r.tau.cols(), r.joints());
    for (size_t j = 0; j < joints.size(); ++j) {
      for (int row = 0; row < r.rows(); ++row) {
        const double t = r.time[row];
        EXPECT_NEAR(r.q(row, static_cast<int>(j)), place(joints[j], t), 2e-4) << row;
        EXPECT_NEAR(r.tau(row, static_cast<int>(j)), 2.0 * joints[j] + t, 1e-8) << row;
      }
    }
  }

  Folder folder_;
};

TEST_F(Joined, FilesOfOneJointEachGiveOneRecordingInTheirOrder) {
  const std::string path = file("a.csv", 0, 1) + "+" + file("b.csv", 1, 1) + "+" + file("c.csv", 2, 1);
  const Recording r = read_recording(path);
  EXPECT_EQ(r.rows(), kRows);
  expect_joints(r, {0, 1, 2});
  RecordingOptions some;
  some.first_row = 50;
  some.row_count = 100;
  EXPECT_EQ(read_recording(path, some).rows(), 100);
}

TEST_F(Joined, JointNumbersAreThoseOfTheColumnsIfTheyDiffer) {
  expect_joints(read_recording(file("b.csv", 1, 2) + "+" + file("a.csv", 0, 1)), {0, 1});
}

TEST_F(Joined, FilesOfDifferentRatesAreInterpolatedOverTheirCommonTime) {
  const Recording r = read_recording(file("a.csv", 0, 1) + "+" + file("b.csv", 1, 1, 130.0, 0.3));
  expect_joints(r, {0, 1});
  EXPECT_GE(r.time[0], 0.3 - 1e-9);
  EXPECT_THROW(read_recording(file("c.csv", 0, 1) + "+" + file("d.csv", 1, 1, 100.0, 50.0)), InvalidInput);
}

// A joint at a tenth of the rate has nothing fast in it, and the rows look as if it had.
TEST_F(Joined, ASlowerFileIsReported) {
  RecordingFacts facts;
  const std::string fast = file("a.csv", 0, 1) + "+" + file("b.csv", 1, 1, 99.0);
  (void)read_recording(fast, RecordingOptions(), facts);
  EXPECT_TRUE(facts.remarks.empty()) << facts.remarks.front();
  const std::string slow = file("a.csv", 0, 1) + "+" + file("c.csv", 1, 1, 10.0);
  (void)read_recording(slow, RecordingOptions(), facts);
  ASSERT_EQ(facts.remarks.size(), 1U);
  EXPECT_EQ(facts.remarks[0], "signals of 2 come every 100 ms, and are interpolated at rows every 10 ms.");
}

// Only files that count their joints are counted on; a name beside a number tells that these are names.
TEST_F(Joined, ANamedJointThatOccursInTwoFilesIsRefused) {
  const std::string named = folder_.write("named.csv", "t,position,elbow_position,effort,elbow_effort\n0,1,2,3,4\n0.01,1.1,2.2,3.3,4.4\n0.02,1,2,3,4\n");
  EXPECT_NE(refusal([&] { (void)read_recording(file("a.csv", 0, 1) + "+" + named); }).find("named.csv: found joint 1, expected one that no file before it has"), std::string::npos);
}

TEST_F(Joined, UnitsFollowTheJointType) {
  const std::string path = file("a.csv", 0, 1) + "+" + file("b.csv", 1, 1);
  RecordingOptions options;
  options.signals.joints = {{"yaw", false}, {"insertion", true}};
  const auto refused = [&](const std::string& key, const std::string& unit) {
    options.signals.units = {{key, unit}};
    return refusal([&] { (void)read_recording(path, options); });
  };
  EXPECT_NE(refused("q2", "deg").find("joint 2 slides"), std::string::npos);
  EXPECT_NE(refused("dq1", "mm/s").find("joint 1 turns"), std::string::npos);
  EXPECT_NE(refused("tau2", "A").find("expected tau=A"), std::string::npos);
  EXPECT_NE(refused("q0", "rad").find("has 2 joints"), std::string::npos);
  EXPECT_EQ(refused("q", "deg"), "");  // of those that turn
  EXPECT_EQ(refused("q2", "mm"), "");
}

TEST_F(Joined, AFileWithAPlusInItsNameIsOneRecording) {
  expect_joints(read_recording(file("a+b.csv", 0, 1)), {0});
  EXPECT_THROW(read_recording(folder_.path("no+such.csv")), InvalidInput);
}

SignalChoice with_held(double position) {
  SignalChoice choice;
  choice.joints = {{"yaw", false}, {"tool", false}};
  choice.held = {{2, {"pitch", false}, position}};
  return choice;
}

TEST_F(Joined, AHeldJointIsLeftOutIfItWasRecorded) {
  RecordingOptions options;
  options.signals = with_held(0.1);
  const std::string all = file("a.csv", 0, 1) + "+" + file("b.csv", 1, 1) + "+" + file("c.csv", 2, 1);
  RecordingFacts facts;
  expect_joints(read_recording(all, options, facts), {0, 2});
  EXPECT_EQ(facts.joints, (std::vector<std::string>{"yaw", "tool"}));
  ASSERT_EQ(facts.remarks.size(), 1U);  // its file has it moving
  EXPECT_NE(facts.remarks[0].find("pitch is held at 0.1 and was "), std::string::npos) << facts.remarks[0];
  // The same of a plain table, of which no name is known.
  Recording whole = read_recording(all);
  const std::string plain = folder_.path("plain.csv");
  write_recording(whole, plain);
  expect_joints(read_recording(plain, options), {0, 2});
  whole.q.col(1).setConstant(0.1);
  write_recording(whole, plain);
  EXPECT_EQ(read_recording(plain, options, facts).joints(), 2);
  EXPECT_TRUE(facts.remarks.empty());
}

TEST_F(Joined, AHeldJointMayBeMissingFromTheFiles) {
  RecordingOptions options;
  options.signals = with_held(0.1);
  expect_joints(read_recording(file("a.csv", 0, 1) + "+" + file("c.csv", 2, 1), options), {0, 2});
}

// A pipe cannot be opened again to find out whether it has the joint.
TEST_F(Joined, AHeldJointMayBeMissingFromAPipe) {
  RecordingOptions options;
  options.signals = with_held(0.1);
  const std::string both = folder_.path("both.csv");
  write_recording(read_recording(file("a.csv", 0, 1) + "+" + file("c.csv", 2, 1)), both);
  const std::string pipe = folder_.path("pipe");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  std::thread writer([&] { std::ofstream(pipe) << std::ifstream(both).rdbuf(); });
  expect_joints(read_recording(pipe, options), {0, 2});
  writer.join();
}

TEST_F(Joined, JointNumbersOfElevenDigitsAreTreatedAsNames) {
  std::string paths[2];
  for (int k = 0; k < 2; ++k)
    paths[k] = folder_.write(std::string(1, char('a' + k)) + ".csv", "t,q99999999999,tau99999999999\n0,1,2\n0.01,2,3\n0.02,3,4\n");
  EXPECT_THROW(read_recording(paths[0] + "+" + paths[1]), InvalidInput);
}

TEST(Arrays, MappedArraysHaveTimeAlongTheirLongerDimension) {
  recordings::ArraySet set;
  recordings::NamedArray in{"input_mat", 300, 2, {}};
  recordings::NamedArray out{"output_mat", 300, 2, {}};
  for (int k = 0; k < 600; ++k) {
    in.values.push_back(k);
    out.values.push_back(-k);
  }
  set.arrays = {in, out};
  RecordingOptions options;
  options.rate = 50.0;
  options.signals.map = {{"q", "input_mat"}, {"tau", "output_mat"}};
  const recordings::Imported found =
      recordings::assemble(recordings::raw_from_arrays(set, "a.mat", "MATLAB", options), "a.mat", options.signals);
  ASSERT_EQ(found.recording.rows(), 300);
  EXPECT_EQ(found.recording.q(7, 1), 15.0);
  EXPECT_EQ(found.recording.tau(7, 0), -14.0);
  EXPECT_NEAR(found.recording.time[50], 1.0, 1e-9);
}

// A file may hold any number of arrays: a message names a few, and groups with signals have a limit.
TEST(Arrays, ThousandsOfArraysAreReportedInOneShortLine) {
  recordings::ArraySet others, groups;
  for (int k = 0; k < 5000; ++k) {
    others.arrays.push_back({text("a", k), 1, 1, {0.0}});
    groups.arrays.push_back({text("g", k, "/q"), 3, 1, {0.0, 1.0, 2.0}});
  }
  RecordingOptions options;
  options.rate = 50.0;
  const std::string said = refusal([&] { recordings::raw_from_arrays(others, "a.npz", "NumPy", options); });
  EXPECT_NE(said.find("found arrays a0, a1, "), std::string::npos) << said;
  EXPECT_NE(said.find(", ... (5000), expected t, q, dq and tau"), std::string::npos) << said;
  EXPECT_TRUE(refuses_with("5000 groups of arrays", [&] { recordings::raw_from_arrays(groups, "a.npz", "NumPy", options); }));
}

}  // namespace
}  // namespace veridyn
