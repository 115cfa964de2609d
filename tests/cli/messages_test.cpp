#include <gtest/gtest.h>

#include "cli/tool.hpp"

// What a user reads when something is wrong: one line with what was found and what was expected, in
// words of the field, of the command that was meant.

namespace veridyn {
namespace {

class Messages : public testing::Test {
 protected:
  void expect(const Words& arguments, int status, const Words& words) const {
    const ToolRun run = run_tool(arguments);
    std::string all;
    for (const std::string& word : arguments) all += word + " ";
    SCOPED_TRACE(all);
    EXPECT_EQ(run.status, status) << run.err;
    EXPECT_EQ(run.error_lines(), 1) << run.err;
    for (const std::string& word : words)
      EXPECT_NE(run.err.find(word), std::string::npos) << word << " is not in: " << run.err;
    for (const char* word : {"not in range", "not in {", "Could not convert", "required TEXT"})
      EXPECT_EQ(run.err.find(word), std::string::npos) << run.err;
  }

  TemporaryFolder folder_;
};

TEST_F(Messages, SuggestTheIntendedCommandOrOption) {
  expect({"calibrate", "links", "planar-2r", "poses.csv", "--fram", "tool"}, 2,
         {"unknown option '--fram' (did you mean '--frame'?); see veridyn calibrate links --help"});
  expect({"calibrate", "link"}, 2,
         {"unknown command 'link' of calibrate, expected one of axis, rcm", "did you mean 'links'?"});
  expect({"dvrk"}, 2, {"no command of dvrk, expected one of emulate"});
  expect({"calibrate", "handeye"}, 2, {"A: found nothing, expected", "see veridyn calibrate handeye --help"});
}

TEST_F(Messages, QuoteTheFoundAndTheExpectedValue) {
  const Words identify = {"identify", "planar-2r", "--train", "a.csv"};
  expect(identify + Words{"--filter-cutoff", "five"}, 2,
         {"--filter-cutoff: found 'five', expected a number that is not negative"});
  expect(identify + Words{"--rows"}, 2, {"--rows: found nothing, expected A:B"});
  expect(identify + Words{"--json"}, 2, {"--json: found nothing, expected FILE;"});
  expect({"cooperate", VERIDYN_SOURCE_DIR "/examples/cooperate/two-arms-spring.yaml", "--boards", "PSM1"}, 2,
         {"--boards: found 1 configurations, expected one for each of 2 arms"});
  expect({"compare", "a", "b", "--significance", "0.9"}, 2,
         {"--significance: found '0.9', expected a number from 0 to 0.5"});
  expect({"kinematics", "planar-2r", "--workspace", "0"}, 2, {"found '0', expected a number from 1 to 1000000"});
  expect({"kinematics", "PSM1", "--inverse=0,0,0,1,0,0,0", "--solver", "newtn"}, 2,
         {"--solver: found 'newtn', expected one of closed-form, newton (did you mean 'newton'?)"});
  expect({"excite", "planar-2r", "-o", folder_.path("x.csv"), "--duration", "-3"}, 2,
         {"--duration: found '-3', expected a number above zero"});
  expect({"simulate", "planar-2r", "--trajectory", "a.csv", "-o", folder_.path("b.csv"), "--seed", "-1"}, 2,
         {"--seed: found '-1', expected a whole number"});
}

// A quaternion of length zero is no turn, and joints outside their limits are named.
TEST_F(Messages, OfKinematicsNameTheInvalidOption) {
  expect({"kinematics", "PSM1", "--inverse=0,0,-0.1,0,0,0,0"}, 2, {"found a quaternion of length zero"});
  expect({"kinematics", "planar-2r", "--forward=0,0,0"}, 2, {"--forward: found 3 joints, expected the 2"});
  const ToolRun beyond = run_tool({"kinematics", "psm-3dof", "--forward=9,0,0.1"});
  EXPECT_EQ(beyond.status, 0);
  EXPECT_NE(beyond.out.find("Outside the limits of yaw 9 (limits "), std::string::npos) << beyond.out;
  const ToolRun within = run_tool({"kinematics", "psm-3dof", "--forward=0,0,0.1"});
  EXPECT_EQ(within.out.find("Outside"), std::string::npos) << within.out;
}

// Values that a file lacks and a command makes up are announced, with their seed.
TEST_F(Messages, AnnounceValuesAssumedForAnIncompleteRobotFile) {
  const ToolRun made = run_tool({"stability", "psm-3dof"});
  EXPECT_NE(made.err.find("has no values for"), std::string::npos) << made.err;
  EXPECT_NE(made.err.find("plausible ones (seed "), std::string::npos) << made.err;
  const ToolRun empty = run_tool({"export", "psm-3dof", "--urdf", folder_.path("a.urdf")});
  EXPECT_EQ(empty.status, 0);
  EXPECT_NE(empty.err.find("a URDF of them has no masses"), std::string::npos) << empty.err;
  // A file that is not there has its own line alone.
  expect({"simulate", "planar-2r", "--trajectory", "nope.csv", "-o", folder_.path("x.csv")}, 3,
         {"nope.csv: found no such file, expected a recording"});
}

TEST_F(Messages, NameMissingInput) {
  const std::string rec = folder_.write("rec.csv", planar_recording(3.0));
  const Words identify = {"identify", "planar-2r", "--quiet", "--train", rec};
  expect(identify + Words{"--prior", "psm-3dof"}, 2, {"--prior: found bodies without values in 'psm-3dof'"});
  expect(identify + Words{"--fix", "elbow=5"}, 0, {"rec.csv: elbow is held at 5 and was ", ": what follows leaves its motion out"});
  expect(identify + Words{"--map", "foo=tau1"}, 2, {"--map: found 'foo'"});
  expect(identify + Words{"--filter-cutoff", "1000"}, 2, {"--filter-cutoff: found 1000 Hz, expected", "50 Hz"});
  expect(identify + Words{"--known-mass", "x@fore"}, 2, {"--known-mass: ", "x"});
  expect({"check", "planar-2r"}, 2, {"found the robot 'planar-2r' alone, expected recordings"});
  const std::string exported = folder_.path("arm.urdf");
  ASSERT_EQ(run_tool({"export", "psm-3dof", "--urdf", exported}).status, 0);
  expect({"check", exported}, 2, {"arm.urdf' alone, expected recordings behind it (veridyn info checks a robot)"});
  expect({"stability", "missing.yaml"}, 3, {"missing.yaml: found no such file, expected a scenario"});
  expect({"check", folder_.write("rec.bag", std::string("\x01\0\x02", 3))}, 3, {"rec.bag", "a whole bag"});
  expect({"info", "nope"}, 3, {"one of: elbow-6r, ", "mtm, mtm-rods, planar-2r, "});
  const std::string poses = folder_.write("poses.csv", "t,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n1,0,0,0,1,0,0,0\n");
  expect({"calibrate", "rcm", poses, "--body", "foo"}, 3, {"poses.csv: found one body without a name"});
  const std::string cell = folder_.write("cell.csv", "mass,raw\n1,100\n1,100\n");
  expect({"loadcell", "calibrate", cell}, 3, {"cell.csv: "});
}

}  // namespace
}  // namespace veridyn
