#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "cli/tool.hpp"

// Every number that a command prints is in the JSON of the same run, to the digits that are printed: as a number, or in a
// remark or a sentence about a recording that the JSON contains literally.

namespace veridyn {
namespace {

using nlohmann::json;

const char* const kArm = R"(<robot name="three">
  <link name="base"/>
  <link name="column"><inertial><origin xyz="0 0 0.1"/><mass value="4"/><inertia ixx="0.03" iyy="0.03" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="upper"><inertial><origin xyz="0.2 0 0"/><mass value="3"/><inertia ixx="0.006" iyy="0.05" izz="0.05" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="fore"><inertial><origin xyz="0.12 0 0.02"/><mass value="1.8"/><inertia ixx="0.003" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="tool0"/>
  <joint name="turn" type="revolute"><parent link="base"/><child link="column"/><axis xyz="0 0 1"/><limit lower="-2.5" upper="2.5" effort="80" velocity="3"/><dynamics damping="2" friction="2"/></joint>
  <joint name="lift" type="revolute"><parent link="column"/><child link="upper"/><origin xyz="0 0 0.3"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="120" velocity="3"/><dynamics damping="2" friction="3"/></joint>
  <joint name="bend" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="0.4 0 0"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="60" velocity="3"/><dynamics damping="1" friction="1.5"/></joint>
  <joint name="flange" type="fixed"><parent link="fore"/><child link="tool0"/><origin xyz="0.3 0 0"/></joint>
</robot>
)";

// The numbers of a result, and its sentences.
struct Said {
  std::vector<double> numbers = {0.0};
  Words sentences;

  void collect(const json& value) {
    if (value.is_number()) numbers.push_back(std::abs(value.get<double>()));
    if (value.is_structured()) numbers.push_back(static_cast<double>(value.size()));  // "21 base parameters"
    if (value.is_string()) sentences.push_back(value.get<std::string>());
    if (!value.is_structured()) return;
    // A sentence about a result repeats numbers that stand beside it; one about a recording may say more than its value.
    const bool repeats = value.is_object() && !value.contains("finding");
    for (const auto& item : value.items()) {
      if (item.key() != "curve" && !(repeats && (item.key() == "sentence" || item.key() == "phrase"))) collect(item.value());
    }
  }

  // Removes those sentences that the JSON contains literally.
  std::string without_sentences(std::string line) const {
    for (const std::string& one : sentences) {
      const size_t at = one.size() < kSentence ? std::string::npos : line.find(one);
      if (at != std::string::npos) line.erase(at, one.size());
    }
    // What follows from the numbers beside it: a range of torques, a resonance, a change in per cent.
    return std::regex_replace(line, std::regex(R"(between \S+ N m and \S+ N m|near \S+ Hz|\([+-]\S+ %;)"), "");
  }

  static constexpr size_t kSentence = 20;  // characters; shorter ones are names
};

struct Printed {
  std::string words;
  double value = 0.0, half_step = 0.0;
};

// Numbers of a line, but for those inside of names, paths and options.
std::vector<Printed> numbers_in(const std::string& line) {
  std::vector<Printed> out;
  const auto in_name = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '.' || c == '/' || c == ':' || c == '='; };
  for (size_t k = 0; k < line.size(); ++k) {
    if (!std::isdigit(static_cast<unsigned char>(line[k]))) continue;
    const bool sign = k > 0 && line[k - 1] == '-';
    const size_t before = sign ? k - 1 : k;
    size_t end = k;
    while (end < line.size() && (std::isdigit(static_cast<unsigned char>(line[end])) || (line[end] == '.' && end + 1 < line.size() && std::isdigit(static_cast<unsigned char>(line[end + 1]))))) ++end;
    double step = 1.0;
    const size_t point = line.find('.', k);
    if (point < end) step = std::pow(10.0, -static_cast<double>(end - point - 1));
    if (end + 2 < line.size() && line[end] == 'e' && (line[end + 1] == '-' || line[end + 1] == '+')) {
      size_t power = end + 2;
      while (power < line.size() && std::isdigit(static_cast<unsigned char>(line[power]))) ++power;
      step *= std::pow(10.0, std::stod(line.substr(end + 1, power - end - 1)));
      end = power;
    }
    const bool name = (before > 0 && in_name(line[before - 1])) || (sign && before > 0 && line[before - 1] != ' ' && line[before - 1] != '(' && line[before - 1] != ',') ||
                      (end < line.size() && (std::isalnum(static_cast<unsigned char>(line[end])) || line[end] == '_' || line[end] == '/'));
    if (!name) out.push_back({line.substr(k, end - k), std::stod(line.substr(k, end - k)), 0.5 * step});
    k = end;
  }
  return out;
}

// In percent, thousandths, degrees or per minute as well.
bool has(const std::vector<double>& numbers, const Printed& printed) {
  for (const double factor : {1.0, 100.0, 1e3, 180.0 / M_PI, 60.0}) {
    for (const double number : numbers) {
      if (std::abs(factor * number - printed.value) <= 1.001 * printed.half_step + 1e-12) return true;
    }
  }
  return false;
}

class EverySentence : public testing::Test {
 protected:
  void SetUp() override {
    arm_ = folder_.write("arm.urdf", kArm);
    for (int k = 0; k < 3; ++k) trajectory(k, 12.0, 1.0);
  }

  void TearDown() override { EXPECT_GT(results_, 0); }

  std::string path(const std::string& name) const { return folder_.path(name); }

  // Every joint moves by the sum of three sines, for two periods.
  void trajectory(int k, double seconds, double size) {
    std::ostringstream rows;
    rows << "t,q1,q2,q3\n";
    for (double t = 0.0; t < seconds; t += 0.01) {
      rows << t;
      for (int j = 0; j < 3; ++j) {
        double q = 0.0;
        for (int h = 1; h <= 3; ++h) q += size * (0.5 - 0.1 * h) * std::sin(2.0 * M_PI / 6.0 * (h + (j + k) % 2) * t + 1.7 * h * (j + 1) + 0.9 * k);
        rows << ',' << q;
      }
      rows << '\n';
    }
    folder_.write("way" + std::to_string(k) + ".csv", rows.str());
  }

  // Three recordings of the arm: two to learn from, one held out.
  Words recorded(const std::string& name, const Words& with = {}) {
    Words out;
    for (int k = 0; k < 3; ++k) {
      out.push_back(path(name + std::to_string(k) + ".csv"));
      const ToolRun run = run_tool(Words{"simulate", arm_, "--trajectory", path("way" + std::to_string(k) + ".csv"), "-o", out.back(), "--seed", std::to_string(k + 3), "--quiet"} + with);
      EXPECT_EQ(run.status, 0) << run.err;
    }
    return out;
  }

  void read(const Words& command) {
    const ToolRun run = run_tool(command + Words{"--json", path("out.json"), "--quiet"});
    if (run.status != 0) return;  // refused in one line; the tests of bad input cover these
    ++results_;
    Said said;
    said.collect(json_of(path("out.json")));
    said.numbers.push_back(95.0);  // of the intervals
    std::istringstream lines(run.out);
    for (std::string line; std::getline(lines, line);) {
      if (line.rfind("  veridyn ", 0) == 0) continue;  // a command to copy
      for (const Printed& one : numbers_in(said.without_sentences(line))) EXPECT_TRUE(has(said.numbers, one)) << command.front() << ": " << one.words << " in: " << line;
    }
  }

  void read_all(const std::string& robot, const Words& rec) {
    read({"check", robot, rec[0], rec[2]});
    read({"identify", robot, "--train", rec[0], rec[1], "--test", rec[2]});
    read({"diagnose", robot, "--train", rec[0], rec[1], "--test", rec[2]});
  }

  TemporaryFolder folder_;
  std::string arm_;
  int results_ = 0;  // of commands that were not refused
};

TEST(ANumberInASentence, MatchesAJsonNumberThatRoundsToIt) {
  const std::vector<double> numbers = {0.01236, -3.5};
  const auto all_found = [&](const std::string& line) {
    const std::vector<Printed> printed = numbers_in(line);
    return !printed.empty() && std::all_of(printed.begin(), printed.end(), [&](const Printed& one) { return has(numbers, one); });
  };
  EXPECT_TRUE(all_found("leaves 1.2 % held out"));
  EXPECT_TRUE(all_found("leaves 1.24e-02 of the torque"));
  EXPECT_FALSE(all_found("leaves 1.3 % held out"));
  EXPECT_FALSE(all_found("leaves 1.2 % held out and 7.1 N m"));
  EXPECT_FALSE(all_found("joint_2 has no figure"));
}

TEST_F(EverySentence, AboutACleanArmAgreesWithTheJson) { read_all(arm_, recorded("clean")); }

TEST_F(EverySentence, AboutASpringAgreesWithTheJson) { read_all(arm_, recorded("spring", {"--effect", "joint_spring:lift:stiffness=12"})); }

TEST_F(EverySentence, AboutALoadAgreesWithTheJson) {
  const Words clean = recorded("clean"), loaded = recorded("loaded", {"--effect", "payload:tool0:mass=0.8"});
  const auto model = [&](const Words& rec, const std::string& name) {
    EXPECT_EQ(run_tool({"identify", arm_, "--train", rec[0], rec[1], "--test", rec[2], "--model-out", path(name), "--quiet"}).status, 0);
    return path(name);
  };
  const std::string before = model(clean, "before.yaml"), after = model(loaded, "after.yaml");
  read({"diagnose", before, "--train", loaded[0], loaded[1], "--test", loaded[2]});
  read({"payload", before, "--recording", loaded[0]});
  read({"compare", before, after});
}

TEST_F(EverySentence, AboutWrongUnitsAgreesWithTheJson) {
  Words rec = recorded("clean");
  for (std::string& one : rec) {
    std::istringstream in(content_of(one));
    std::ostringstream out;
    std::string line;
    std::getline(in, line);
    out << line << '\n';
    while (std::getline(in, line)) {
      std::istringstream fields(line);
      std::string field;
      for (int c = 0; std::getline(fields, field, ','); ++c) {
        const bool angle = c >= 1 && c <= 6;  // columns: t, q1..3, dq1..3, tau1..3
        out << (c > 0 ? "," : "") << (angle ? 180.0 / M_PI : 1.0) * std::stod(field);
      }
      out << '\n';
    }
    one = folder_.write("deg-" + one.substr(one.rfind('/') + 1), out.str());
  }
  read_all(arm_, rec);
}

TEST_F(EverySentence, AboutAnotherGravityAgreesWithTheJson) { read_all(arm_, recorded("wall", {"--gravity", "9.81,0,0"})); }

// Mounted with a lean of 30 degrees: the errors of all joints depend on position, and none of them sticks anywhere.
TEST_F(EverySentence, AboutATiltedBaseReportsNoStickingPositions) {
  const std::string robots = VERIDYN_SOURCE_DIR "/examples/own_robot/";
  Words rec;
  for (const char* seed : {"20", "21", "22"}) {
    rec.push_back(path(std::string(seed) + ".csv"));
    EXPECT_EQ(run_tool({"excite", robots + "labarm.urdf", "-o", path("motion.csv"), "--seed", seed, "--solver", "random", "--quiet"}).status, 0);
    EXPECT_EQ(run_tool({"simulate", robots + "true-arm.yaml", "--trajectory", path("motion.csv"), "-o", rec.back(), "--seed", seed, "--noise", "low",
                        "--gravity", "0,4.9,-8.5", "--quiet"}).status, 0);
  }
  const ToolRun run = run_tool({"diagnose", robots + "labarm.urdf", "--train", rec[0], rec[1], "--test", rec[2], "--quiet"});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.out.find("a base that leans by"), std::string::npos) << run.out;
  EXPECT_EQ(run.out.find("sticking"), std::string::npos) << run.out;
  ++results_;
}

TEST_F(EverySentence, AboutAShortOrStillRecordingAgreesWithTheJson) {
  for (int k = 0; k < 3; ++k) trajectory(k, 2.5, 1.0);
  read_all(arm_, recorded("short"));
  for (int k = 0; k < 3; ++k) trajectory(k, 12.0, 0.0);
  read_all(arm_, recorded("still"));
}

}  // namespace
}  // namespace veridyn
