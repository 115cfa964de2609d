#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>

#include "cli/tool.hpp"

// Bad input ends with status 3 and one line that names the file, the line and column where there is
// one, what was found and what was expected. Nothing is written.

namespace veridyn {
namespace {

class BadInput : public testing::Test {
 protected:
  // The good recording with line `number` (from 1, the header) replaced.
  std::string with_line(int number, const std::string& line) const {
    std::istringstream good(planar_recording(3.0));
    std::string out;
    int at = 0;
    for (std::string old; std::getline(good, old);) out += (++at == number ? line : old) + "\n";
    return folder_.write("recording.csv", out);
  }

  ToolRun identify(const std::string& robot, const std::string& recording) const {
    return run_tool({"identify", robot, "--train", recording, "--json", folder_.path("out.json"),
                     "--model-out", folder_.path("model.yaml"), "--quiet"});
  }

  void expect_refused(const ToolRun& run, int status, const Words& words) const {
    EXPECT_EQ(run.status, status) << run.err;
    EXPECT_EQ(run.error_lines(), 1) << run.err;
    EXPECT_EQ(run.out, "");
    EXPECT_EQ(run.err.rfind("veridyn: ", 0), 0u) << run.err;
    for (const std::string& word : words) {
      EXPECT_NE(run.err.find(word), std::string::npos) << word << " is not in: " << run.err;
    }
    for (const std::string& name : folder_.files()) EXPECT_EQ(name, "recording.csv");
  }

  TemporaryFolder folder_;
};

// Every option that writes a file: none goes over a file that is read.
TEST_F(BadInput, AnOutputPathEqualToAnInputIsRefused) {
  const std::string content = planar_recording(3.0);
  const std::string recording = folder_.write("recording.csv", content);
  const std::string list = folder_.write("list.csv", "a,recording.csv\nb,x.csv\nc,y.csv\n");
  const std::string model = folder_.path("model.yaml");
  ASSERT_EQ(run_tool({"export", "planar-2r", "--yaml", model, "--quiet"}).status, 0);
  const std::string robot = content_of(model);
  std::vector<Words> over;
  for (const char* option : {"--factor-out", "--model-out", "--json", "--report"})
    over.push_back({"identify", "planar-2r", "--train", recording, option, recording});
  for (const char* option : {"--urdf", "--mjcf", "--sdf", "--cpp", "--json", "--yaml",
                             "--dvrk-gravity", "--dvrk-scales"})
    over.push_back({"export", model, option, model});
  for (const char* option : {"--model-out", "--json"})
    over.push_back({"fleet", "planar-2r", list, option, recording});
  for (const char* option : {"-o", "--coefficients"})
    over.push_back({"excite", model, "-o", folder_.path("m.csv"), option, model});
  over.push_back({"simulate", "planar-2r", "--trajectory", recording, "-o", recording});
  for (const Words& words : over) {
    const ToolRun run = run_tool(words);
    EXPECT_EQ(run.status, 2) << words[0] << " " << words[words.size() - 2] << ": " << run.err;
    EXPECT_EQ(content_of(recording), content) << words[words.size() - 2];
    EXPECT_EQ(content_of(model), robot) << words[words.size() - 2];
  }
}

TEST_F(BadInput, AMissingRecordingIsNamed) {
  expect_refused(identify("planar-2r", folder_.path("missing.csv")), 3, {"missing.csv"});
}

// A folder opens like a file, and reading it fails: everywhere in one line that says so.
TEST_F(BadInput, AFolderGivenAsAFileIsRefused) {
  const std::string folder = folder_.path("folder");
  ASSERT_TRUE(std::filesystem::create_directory(folder));
  const std::string recording = folder_.write("recording.csv", planar_recording(3.0));
  const Words cases[] = {
      {"identify", "planar-2r", "--train", folder},
      {"identify", "planar-2r", "--factors", folder},
      {"check", folder},
      {"info", folder},
      {"compare", "planar-2r", folder},
      {"fleet", "planar-2r", folder},
      {"kinematics", "planar-2r", "--forward", folder},
      {"loadcell", "calibrate", folder},
      {"loadcell", "read", "udp:0", "--seconds", "0.1", "--calibration", folder},
      {"calibrate", "rcm", folder},
      {"cooperate", folder},
      {"stability", folder},
      {"dvrk", "config", "--config", folder},
      {"simulate", "planar-2r", "--trajectory", recording, "-o", folder_.path("o.csv"), "--controller", "pid",
       "--gains", folder},
  };
  for (const Words& words : cases) {
    const ToolRun run = run_tool(words[0] == "dvrk" ? words : words + Words{"--quiet"});
    EXPECT_EQ(run.status, 3) << words[0] << ": " << run.err;
    EXPECT_NE(run.err.find("folder: found a folder"), std::string::npos) << words[0] << ": " << run.err;
    EXPECT_EQ(run.error_lines(), 1) << run.err;
  }
}

// Where a motion has a gap, its file and row are named.
TEST_F(BadInput, AMotionWithAGapIsRefused) {
  const std::string motion = with_line(5, "0.03,nan,0,0,0,0,0");
  const ToolRun run = run_tool({"simulate", "planar-2r", "--trajectory", motion, "-o", folder_.path("o.csv"), "--quiet"});
  expect_refused(run, 3, {"recording.csv", "gap", "row 3"});
}

TEST_F(BadInput, AnUnknownRobotIsRefusedWithASuggestion) {
  const std::string recording = folder_.write("recording.csv", planar_recording(3.0));
  expect_refused(identify("planar-3r", recording), 3, {"planar-3r", "planar-2r"});
}

// What no machine could hold is refused before it is begun, with the number of rows.
TEST_F(BadInput, MoreRowsThanMemoryHoldsAreRefused) {
  const std::string recording = folder_.write("recording.csv", planar_recording(3.0));
  const Words too_many[] = {
      {"identify", "planar-2r", "--train", recording, "--resample", "1e12"},
      {"excite", "planar-2r", "-o", folder_.path("m.csv"), "--duration", "999999", "--rate", "1e5"},
      {"simulate", "planar-2r", "--trajectory", recording, "-o", folder_.path("o.csv"),
       "--sample-rate", "1e11"}};
  for (const Words& words : too_many) {
    const ToolRun run = run_tool(words + Words{"--quiet"});
    EXPECT_GE(run.status, 2) << words[0];
    EXPECT_LE(run.status, 3) << words[0];
    EXPECT_NE(run.err.find("what this machine holds"), std::string::npos) << run.err;
    EXPECT_EQ(run.error_lines(), 1) << run.err;
  }
  // One wrong time stamp asks for as much.
  expect_refused(identify("planar-2r", with_line(301, "1e9,1,1,1,1,1,1")), 3,
                 {"recording.csv", "what this machine holds"});
}

TEST_F(BadInput, AnEmptyRecordingIsRefused) {
  expect_refused(identify("planar-2r", folder_.write("recording.csv", "")), 3, {"recording.csv"});
}

TEST_F(BadInput, ARaggedRowIsRefusedWithItsLine) {
  expect_refused(identify("planar-2r", with_line(57, "0.55,1,2,3,4,5")), 3,
                 {"recording.csv:57", "6", "7"});
}

TEST_F(BadInput, TextInANumberIsRefusedWithItsPlace) {
  expect_refused(identify("planar-2r", with_line(57, "0.55,1,2,3,4x,5,6")), 3,
                 {"recording.csv:57:5", "4x", "number"});
}

// No error: recorders write rows twice.
TEST_F(BadInput, ARepeatedTimeStampIsRemarked) {
  const ToolRun run = identify("planar-2r", with_line(57, "0.54,1,2,3,4,5,6"));
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.err.find("1 row repeats the time stamp before"), std::string::npos)
      << run.err;
}

TEST_F(BadInput, TimeThatRunsBackIsRefused) {
  expect_refused(identify("planar-2r", with_line(57, "0.2,1,2,3,4,5,6")), 3,
                 {"recording.csv:57", "0.2"});
}

TEST_F(BadInput, AWrongNumberOfJointsIsRefused) {
  const std::string recording = folder_.write("recording.csv", planar_recording(3.0));
  expect_refused(identify("elbow-6r", recording), 3,
                 {"recording.csv", "2 joints", "elbow-6r", "6"});
}

TEST_F(BadInput, WrongColumnsOfAHeaderlessFileAreRefused) {
  std::string content = planar_recording(3.0);
  const std::string recording =
      folder_.write("recording.csv", content.substr(content.find('\n') + 1));
  const ToolRun run = run_tool({"identify", "planar-2r", "--train", recording, "--quiet",
                                "--columns", "q,dq,tau", "--rate", "100"});
  expect_refused(run, 3, {"recording.csv", "7"});
}

TEST_F(BadInput, ARecordingOfGapsAloneIsRefused) {
  std::string content = "t,q1,q2,dq1,dq2,tau1,tau2\n";
  for (int k = 0; k < 300; ++k) content += std::to_string(0.01 * k) + ",nan,nan,nan,nan,nan,nan\n";
  const ToolRun run = identify("planar-2r", folder_.write("recording.csv", content));
  expect_refused(run, 3, {"recording.csv"});
}

TEST_F(BadInput, AnOutputPathThatCannotBeWrittenIsRefused) {
  const std::string recording = folder_.write("recording.csv", planar_recording(3.0));
  const std::string nowhere = folder_.path("no-such-folder/out");
  for (const char* option : {"--json", "--model-out"}) {
    const ToolRun run = run_tool({"identify", "planar-2r", "--train", recording, option, nowhere});
    expect_refused(run, 3, {"no-such-folder"});
  }
  const ToolRun info = run_tool({"info", "planar-2r", "--json", folder_.path("")});
  expect_refused(info, 3, {"folder"});
}

TEST_F(BadInput, AnExistingResultFileIsKeptIfTheCommandFails) {
  const std::string old = folder_.write("out.json", "old");
  const ToolRun run = run_tool(
      {"identify", "planar-2r", "--train", folder_.path("missing.csv"), "--json", old, "--quiet"});
  EXPECT_EQ(run.status, 3);
  EXPECT_EQ(content_of(old), "old");
}

// Data that cannot answer: status 4, one line with the reason.

TEST_F(BadInput, UndeterminedParametersOfAJointAtRestAreNamed) {
  const std::string recording = folder_.write("recording.csv", planar_recording(8.0, 1.0, 0.0));
  expect_refused(identify("planar-2r", recording), 4,
                 {"joint elbow never moves", "viscous_friction(elbow).coefficient"});
}

TEST_F(BadInput, AllZeroRecordingsAreRefused) {
  std::string content = "t,q1,q2,dq1,dq2,tau1,tau2\n";
  for (int k = 0; k < 800; ++k) content += std::to_string(0.01 * k) + ",0,0,0,0,0,0\n";
  const ToolRun run = identify("planar-2r", folder_.write("recording.csv", content));
  expect_refused(run, 4, {"shoulder", "elbow", "never move"});
}

TEST_F(BadInput, ASelectionWithoutRowsIsRefused) {
  const std::string recording = folder_.write("recording.csv", planar_recording(3.0));
  const ToolRun run = run_tool({"identify", "planar-2r", "--train", recording, "--quiet",
                                "--drop-start", "2", "--drop-end", "2"});
  expect_refused(run, 4, {"recording.csv", "no usable samples"});
}

// Rows of a file that is fine for everything but what is changed here.
std::string changed(const std::string& recording, const std::function<void(std::vector<double>&)>& change, int rows) {
  std::istringstream in(recording);
  std::string line, out;
  std::getline(in, out);
  out += "\n";
  for (int k = 0; k < rows && std::getline(in, line); ++k) {
    std::vector<double> values;
    std::istringstream fields(line);
    for (std::string field; std::getline(fields, field, ',');) values.push_back(std::stod(field));
    change(values);
    for (std::size_t c = 0; c < values.size(); ++c) out += (c > 0 ? "," : "") + fmt::format("{}", values[c]);
    out += "\n";
  }
  return out;
}

// Neither a crash nor a number: three rows, a clock a thousand times too fast, torques of zero.
TEST_F(BadInput, EveryCommandExitsWithStatus4OnUndeterminedData) {
  const auto as_it_is = [](std::vector<double>&) {};
  const std::string good = planar_recording(12.0);
  const std::string three = changed(good, as_it_is, 3);
  const std::string fast = changed(good, [](std::vector<double>& v) { v[0] *= 1e-3; }, 1200);
  const std::string zero = changed(good, [](std::vector<double>& v) { v[5] = v[6] = 0.0; }, 1200);
  const std::string tiny = changed(good, [](std::vector<double>& v) { v[5] *= 1e-200, v[6] *= 1e-200; }, 1200);
  const TemporaryFolder other;
  const std::string held_out = other.write("good.csv", good);
  for (const std::string& content : {three, fast, zero, tiny}) {
    const std::string bad = folder_.write("recording.csv", content);
    expect_refused(run_tool({"identify", "planar-2r", "--train", bad, "--quiet"}), 4, {"recording.csv"});
    expect_refused(run_tool({"identify", "planar-2r", "--train", bad, "--prior", "planar-2r", "--quiet"}), 4, {"recording.csv"});
    expect_refused(run_tool({"identify", "planar-2r", "--train", held_out, "--test", bad, "--quiet"}), 3, {"recording.csv"});
    expect_refused(run_tool({"diagnose", "planar-2r", "--train", bad, "--test", held_out, "--quiet"}), 4, {"recording.csv"});
    expect_refused(run_tool({"diagnose", "planar-2r", "--train", held_out, "--test", bad, "--quiet"}), 3, {"recording.csv"});
    expect_refused(run_tool({"payload", "planar-2r", bad, "--quiet"}), 4, {"recording.csv"});
  }
  // A check is an answer, whatever it finds.
  for (const std::string& content : {three, fast, zero, tiny}) {
    const ToolRun run = run_tool({"check", "planar-2r", folder_.write("recording.csv", content), "--quiet"});
    EXPECT_EQ(run.status, 0) << run.err;
  }
}

// Numbers whose squares are none: refused where the robot is read, and not left to a decomposition.
TEST_F(BadInput, ARobotFileWithExcessiveNumbersIsRefused) {
  const std::string recording = folder_.write("recording.csv", planar_recording(3.0));
  const TemporaryFolder other;
  ASSERT_EQ(run_tool({"export", "planar-2r", "--yaml", other.path("good.yaml"), "--quiet"}).status, 0);
  const std::string good = content_of(other.path("good.yaml"));
  const struct {
    const char *from, *to, *word;
  } cases[] = {
      {"gravity: [0", "gravity: [1e300", "robot.yaml: arm 'planar-2r': gravity is beyond"},
      {"dh: [l1", "dh: [1e200", "frame 'upper'"},
      {"com: [-l1/2", "com: [1e200", "no finite number"},
      {"revolute: {shoulder: 1}", "revolute: {shoulder: 1e300}", "frame 'upper'"},
  };
  for (const auto& one : cases) {
    std::string text = good;
    const auto at = text.find(one.from);
    ASSERT_NE(at, std::string::npos) << one.from << " is not in " << good;
    text.replace(at, std::string(one.from).size(), one.to);
    const std::string robot = other.write("robot.yaml", text);
    expect_refused(run_tool({"info", robot}), 3, {one.word});
    expect_refused(identify(robot, recording), 3, {one.word});
  }
}

// The default filter does not fit a rate as low as this: the recording is bad input, and no option was wrong.
TEST_F(BadInput, ASamplingRateTooLowForTheDefaultFilterIsRefused) {
  const std::string slow = changed(planar_recording(12.0), [](std::vector<double>& v) { v[0] *= 1e3; }, 1200);
  const std::string recording = folder_.write("recording.csv", slow);
  const ToolRun run = identify("planar-2r", recording);
  EXPECT_EQ(run.status, 3) << run.err;
  EXPECT_NE(run.err.find("recording.csv: found a sampling rate of 0.1 Hz, expected more than 10 Hz"), std::string::npos) << run.err;
  EXPECT_EQ(run_tool({"identify", "planar-2r", "--train", recording, "--filter-cutoff", "1", "--quiet"}).status, 2);
}

// Steps of 0.1 s are a rate of 10 Hz, or by rounding a little more: a filter there would never settle.
TEST_F(BadInput, ARateOfTwiceTheCutOffIsRefused) {
  for (const double stretch : {10.0, 10.0 * (1.0 - 1e-12)}) {
    const std::string ten = changed(planar_recording(12.0), [&](std::vector<double>& v) { v[0] *= stretch, v[3] /= stretch, v[4] /= stretch; }, 1200);
    const std::string recording = folder_.write("recording.csv", ten);
    expect_refused(identify("planar-2r", recording), 3, {"recording.csv: found a sampling rate of 10 Hz, expected more than 10 Hz"});
    const ToolRun chosen = run_tool({"identify", "planar-2r", "--train", recording, "--filter-cutoff", "5.0000000000001", "--quiet"});
    EXPECT_EQ(chosen.status, 2) << chosen.err;
  }
}

// Of several formats one refuses: none is written.
TEST_F(BadInput, AnExportThatIsRefusedLeavesNoFile) {
  const TemporaryFolder other;
  ASSERT_EQ(run_tool({"export", "planar-2r", "--yaml", other.path("good.yaml"), "--quiet"}).status, 0);
  std::string text = content_of(other.path("good.yaml"));
  const auto at = text.find("mass: ");
  ASSERT_NE(at, std::string::npos) << text;
  text.replace(at, text.find_first_of(",\n", at) - at, "mass: 0");
  const ToolRun run = run_tool({"export", other.write("robot.yaml", text), "--urdf", folder_.path("a.urdf"), "--mjcf",
                                folder_.path("b.xml"), "--sdf", folder_.path("c.sdf"), "--report", folder_.path("d.html"), "--quiet"});
  expect_refused(run, 3, {"mass of 0 kg"});
  // Found out late: the arm has no rows of gravity, the file of torques at rest is missing, MuJoCo's file is another robot's.
  const std::string psm = other.path("psm.yaml");
  ASSERT_EQ(run_tool({"export", "psm-3dof-rods", "--yaml", psm, "--quiet"}).status, 0);
  const std::string own = other.path("own.xml");
  ASSERT_EQ(run_tool({"export", psm, "--mjcf", own, "--quiet"}).status, 0);
  const std::string good = other.path("good.yaml");
  const Words all = {"--quiet", "--urdf", folder_.path("a.urdf"), "--cpp", folder_.path("b.h"), "--yaml", folder_.path("c.yaml"), "--json", folder_.path("d.json")};
  const std::string gravity = folder_.path("g.json");
  expect_refused(run_tool(Words{"export", good, "--dvrk-gravity", gravity} + all), 3, {"found no dVRK arm"});
  expect_refused(run_tool(Words{"export", psm, "--dvrk-gravity", gravity, "--static-torques", other.path("none.csv"), "--dvrk-arm", "PSM1"} + all), 3, {"none.csv"});
  expect_refused(run_tool(Words{"export", good, "--mjcf", folder_.path("e.xml"), "--into", own} + all), 3, {"own.xml"});
}

TEST_F(BadInput, AFilterCutOffBelowOneMillihertzIsRefusedInEveryCommand) {
  const std::string recording = folder_.write("recording.csv", planar_recording(3.0));
  const std::vector<Words> commands = {{"identify", "planar-2r", "--train", recording},
                                       {"diagnose", "planar-2r", "--train", recording, "--test", recording},
                                       {"payload", "planar-2r", recording}};
  for (const Words& command : commands) {
    const ToolRun run = run_tool(command + Words{"--filter-cutoff", "1e-9", "--quiet"});
    EXPECT_EQ(run.status, 2) << command.front() << ": " << run.err;
    EXPECT_NE(run.err.find("--filter-cutoff: found 1e-09 Hz, expected at least 0.001 Hz"), std::string::npos) << run.err;
  }
}

TEST_F(BadInput, CheckNamesTheUnreadableFile) {
  const std::string recording = folder_.write("recording.csv", planar_recording(3.0));
  const ToolRun run = run_tool(
      {"check", recording, folder_.path("missing.csv"), "--json", folder_.path("out.json")});
  expect_refused(run, 3, {"missing.csv"});
}

TEST(ProgramFault, WritingStandardOutputToAFullDiskIsAFailure) {
  if (!std::ofstream("/dev/full").is_open()) GTEST_SKIP() << "no /dev/full here";
  const std::string command =
      std::string(VERIDYN_TOOL) + " info planar-2r > /dev/full 2> /dev/null";
  EXPECT_NE(std::system(command.c_str()), 0);
}

// Insertion moves the tip along the tool: no point of it keeps its place.
TEST(RemoteCentre, IsRefusedForATipThatSlidesAlongItsTool) {
  const TemporaryFolder folder;
  std::string joints = "q1,q2,q3\n";
  for (int k = 0; k < 30; ++k)
    joints += std::to_string(0.3 * std::sin(0.5 * k)) + "," + std::to_string(0.3 * std::cos(0.3 * k)) +
              "," + std::to_string(0.1 + 0.05 * std::sin(0.7 * k)) + "\n";
  const std::string poses = folder.path("poses.csv");
  const ToolRun forward = run_tool({"kinematics", "psm-3dof", "--forward",
                                    folder.write("joints.csv", joints), "-o", poses, "--quiet"});
  ASSERT_EQ(forward.status, 0) << forward.err;
  const ToolRun run = run_tool({"calibrate", "rcm", poses, "--quiet"});
  EXPECT_EQ(run.status, 4) << run.out << run.err;
  EXPECT_NE((run.out + run.err).find("contradict any centre"), std::string::npos) << run.out << run.err;
}

TEST(RepeatedRecordings, AreWarnedOfEvenUnderAnotherName) {
  const TemporaryFolder folder;
  const std::string one = folder.write("one.csv", planar_recording(3.0));
  const std::string copy = folder.write("copy.csv", planar_recording(3.0));
  const std::string other = folder.write("other.csv", planar_recording(3.0, 0.8, 1.1));
  const Words identify = {"identify", "planar-2r", "--quiet", "--train", one};
  const std::string words = "counts once more";
  EXPECT_NE(run_tool(identify + Words{one}).err.find(words), std::string::npos);
  EXPECT_NE(run_tool(identify + Words{copy}).err.find("copy.csv holds the same as"), std::string::npos);
  EXPECT_EQ(run_tool(identify + Words{other}).err.find(words), std::string::npos);
  const std::string many = run_tool(identify + Words{copy, copy, one}).err;
  EXPECT_NE(many.find("copy.csv and 2 others hold the same as"), std::string::npos) << many;
  EXPECT_EQ(many.find("once more"), many.rfind("once more")) << many;
}

TEST(ColumnFiles, BlanksWithinANumberAreNotDropped) {
  const TemporaryFolder folder;
  const ToolRun run = run_tool({"loadcell", "calibrate",
                                folder.write("cell.csv", "mass, raw\n0, 100\n1, 2 00\n"), "--quiet"});
  EXPECT_EQ(run.status, 3) << run.out;
  EXPECT_NE(run.err.find("cell.csv:3: found '2 00' in column raw"), std::string::npos) << run.err;
}

TEST(LoadCell, TwoReadingsGiveNoInterval) {
  const TemporaryFolder folder;
  const ToolRun run = run_tool({"loadcell", "calibrate",
                                folder.write("cell.csv", "mass, raw\n0, 100\n1, 200\n"), "--quiet"});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.out.find("no interval from 2 readings"), std::string::npos) << run.out;
  EXPECT_EQ(run.out.find("nan"), std::string::npos) << run.out;
}

}  // namespace
}  // namespace veridyn
