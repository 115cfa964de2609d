#include <gtest/gtest.h>
#include <regex>

#include "cli/tool.hpp"

// Wrong usage ends with status 2 and one line that helps; help and version with 0.

namespace veridyn {
namespace {

using testing::Test;

void expect_usage_error(const Words& arguments, const std::string& words) {
  const ToolRun run = run_tool(arguments);
  EXPECT_EQ(run.status, 2) << run.err;
  EXPECT_EQ(run.error_lines(), 1) << run.err;
  EXPECT_EQ(run.out, "");
  EXPECT_EQ(run.err.rfind("veridyn: ", 0), 0u) << run.err;
  EXPECT_NE(run.err.find(words), std::string::npos) << run.err;
}

TEST(Usage, VersionIsOneLineOnStandardOutput) {
  for (const Words& words : {Words{"--version"}, Words{"identify", "--version"}}) {
    const ToolRun run = run_tool(words);
    EXPECT_EQ(run.status, 0);
    EXPECT_TRUE(std::regex_match(run.out, std::regex("veridyn [0-9]+\\.[0-9]+\\.[0-9]+\n"))) << run.out;
    EXPECT_EQ(run.err, "");
  }
}

TEST(Usage, HelpNamesEveryCommandAndEveryOption) {
  const ToolRun tool = run_tool({"--help"});
  EXPECT_EQ(tool.status, 0);
  for (const char* word : {"info", "check", "identify", "export"}) {
    EXPECT_NE(tool.out.find(word), std::string::npos) << word;
  }
  const ToolRun identify = run_tool({"identify", "--help"});
  EXPECT_EQ(identify.status, 0);
  for (const char* word :
       {"--train",        "--test",      "--method",    "--weights",    "--condition",
        "--known-mass",   "--model-out", "--prior",     "--json",       "--filter-cutoff",
        "--filter-order", "--filtering", "--velocity",  "--resample",   "--rate",
        "--columns",      "--rows",      "--test-rows", "--drop-start", "--drop-end",
        "--decimation",   "--threads",   "--quiet",     "--version",    "--report"}) {
    EXPECT_NE(identify.out.find(word), std::string::npos) << word;
  }
}

TEST(Usage, WithoutACommandTheCommandsAreListed) {
  expect_usage_error({}, "expected one of info, check, identify");
}

TEST(Usage, AMisspeltCommandIsCorrected) {
  expect_usage_error({"idenfity", "planar-2r"}, "unknown command 'idenfity'");
  expect_usage_error({"idenfity", "planar-2r"}, "did you mean 'identify'?");
}

TEST(Usage, AMisspeltOptionIsCorrected) {
  expect_usage_error({"identify", "planar-2r", "--trian", "a.csv"},
                     "unknown option '--trian' (did you mean '--train'?)");
  expect_usage_error({"identify", "planar-2r", "--train", "a.csv", "--filter-cutof=3"},
                     "unknown option '--filter-cutof' (did you mean '--filter-cutoff'?)");
}

TEST(Usage, ARecordingWithoutTheTrainOptionIsNamed) {
  expect_usage_error({"identify", "planar-2r", "a.csv"}, "found 'a.csv', which nothing asks for; recordings follow --train or --test");
  EXPECT_EQ(run_tool({"info", "planar-2r", "a.csv"}).err.find("--train"), std::string::npos);
}

TEST(Usage, MissingArgumentsAreNamed) {
  expect_usage_error({"identify", "planar-2r"}, "--train");
  expect_usage_error({"identify", "--train", "a.csv"}, "ROBOT");
  expect_usage_error({"check"}, "REC");
  expect_usage_error({"info"}, "ROBOT");
  expect_usage_error({"export", "planar-2r"}, "--urdf");
}

TEST(Usage, BadValuesAreNamedWithWhatIsExpected) {
  const Words identify = {"identify", "planar-2r", "--train", "a.csv"};
  expect_usage_error(identify + Words{"--method", "feasable"},
                     "expected one of ols, wls, feasible, iv, didim (did you mean 'feasible'?)");
  expect_usage_error(identify + Words{"--filtering", "both"}, "matched, signals");
  expect_usage_error(identify + Words{"--filter-cutoff", "five"}, "--filter-cutoff");
  expect_usage_error(identify + Words{"--filter-cutoff", "-1"}, "--filter-cutoff");
  expect_usage_error(identify + Words{"--filter-order", "0"}, "--filter-order");
  expect_usage_error(identify + Words{"--threads", "-2"}, "--threads");
  expect_usage_error(identify + Words{"--rows", "100"}, "expected rows A:B");
  expect_usage_error(identify + Words{"--rows", "100:20"}, "expected rows A:B");
  expect_usage_error(identify + Words{"--test-rows", "a:b"}, "--test-rows");
  expect_usage_error(identify + Words{"--columns", "q,velocity"}, "found 'velocity'");
  expect_usage_error(identify + Words{"--method", "wls", "--prior", "planar-2r"}, "--prior");
}

// Options that nothing would use are refused, before any file is read.
TEST(Usage, OptionsWithoutEffectAreRefused) {
  const Words identify = {"identify", "planar-2r", "--train", "a.csv"};
  const Words simulate = {"simulate", "planar-2r", "--trajectory", "a.csv", "-o", "b.csv"};
  const Words replay = {"simulate", "planar-2r", "--replay", "a.csv"};
  const Words excite = {"excite", "planar-2r", "-o", "b.csv"};
  const Words run = {"dvrk", "run", "--arm", "PSM1", "--trajectory", "a.csv", "-o", "b.csv"};
  const Words weightless = {"dvrk",  "run",          "--arm",   "PSM1",    "-o",
                            "b.csv", "--controller", "gravity", "--model", "no.yaml"};
  const struct {
    Words words;
    const char* option;
    const char* value;
    const char* needs;
  } cases[] = {
      {identify + Words{"--method", "ols"}, "--weights", "range", "a method other than ols"},
      {identify + Words{"--method", "wls"}, "--signs", "any", "--method feasible"},
      {identify + Words{"--method", "ols"}, "--condition", "pseudo-inertia", "--method feasible"},
      {identify, "--test-rows", "1:9", "--test"},
      {simulate, "--kp", "1,1", "--controller pid"},
      {simulate, "--gains", "g.yaml", "--controller pid"},
      {simulate, "--control-rate", "500", "--controller pid"},
      {simulate, "--encoder-delay", "0.1", "--controller pid"},
      {simulate, "--torque-limit", "1,1", "--controller pid"},
      {simulate, "--drive", "torques", "--replay"},
      {simulate, "--filter-cutoff", "3", "--replay"},
      {simulate, "--set-point-cutoff", "3", "--replay"},
      {simulate, "--breakaway-speed", "3", "--breakaway"},
      {replay, "--noise", "low", "--trajectory"},
      {replay, "--effect", "backlash:1", "--trajectory"},
      {replay, "--seed", "3", "--trajectory"},
      {replay, "--model-out", "c.yaml", "--trajectory"},
      {replay + Words{"--drive", "torques"}, "--kp", "1,1", "--replay led by"},
      {replay + Words{"--breakaway", "elbow"}, "--drive", "torques", "without --breakaway"},
      {excite + Words{"--criterion", "condition"}, "--between", "payload:fore,torque_gain:1",
       "--criterion discriminate"},
      {excite, "--clearance", "0.1", "--sphere"},
      {excite, "--obstacle", "0,0,0,1", "--sphere"},
      {run, "--gains", "g.yaml", "--model"},
      {run, "--stiffness", "300", "--controller impedance"},
      {run, "--tip", "wrist", "--controller impedance"},
      {run, "--seconds", "3", "--controller gravity"},
      {run, "--robot", "PSM2", "--config"},
      {weightless, "--largest-error", "1", "another controller"},
      {weightless, "--gains", "g.yaml", "another controller than gravity"},
      {{"dvrk", "emulate", "--arm", "PSM1", "--port", "0"}, "--start", "1,1,1", "--model"},
      {{"kinematics", "planar-2r", "--forward", "0,0"}, "--start", "0,0", "--inverse"},
      {{"kinematics", "planar-2r", "--inverse", "0.5,0,0"},
       "--solver",
       "closed-form",
       "a closed form"},
      {{"watch", "planar-2r", "rec.csv"}, "--idle", "3", "--follow"},
  };
  for (const auto& one : cases) {
    SCOPED_TRACE(std::string(one.option) + " of " + one.words[0]);
    const std::string says = std::string(one.option) + ": means nothing here, it needs ";
    expect_usage_error(one.words + Words{one.option, one.value}, says);
    expect_usage_error(one.words + Words{one.option, one.value}, one.needs);
  }
}

// A value that an option cannot have is wrong usage also where only the arm tells.
TEST(Usage, OptionValuesThatDoNotFitTheArmAreUsageErrors) {
  const TemporaryFolder folder;
  const std::string rec = folder.write("rec.csv", planar_recording(3.0));
  const std::string out = folder.path("out.csv");
  const Words identify = {"identify", "planar-2r", "--quiet", "--train", rec};
  const Words simulate = {"simulate", "planar-2r", "--quiet", "--trajectory", rec, "-o", out};
  const Words pid = simulate + Words{"--controller", "pid"};
  const Words excite = {"excite", "planar-2r", "--quiet", "-o", out};
  const Words emulate = {"dvrk", "emulate", "--port", "0", "--seconds", "0.1"};
  const Words psm1 = emulate + Words{"--arm", "PSM1"};
  const std::string io = folder.path("io.xml");
  ASSERT_EQ(run_tool({"dvrk", "config", "--arm", "PSM1", "-o", io}).status, 0);
  const struct {
    Words words;
    std::string says;
  } cases[] = {
      {identify + Words{"--known-mass", "1kg"}, "--known-mass: "},
      {identify + Words{"--known-mass", "1@fore"}, "found one recording"},
      {identify + Words{rec, "--known-mass", "1@for"}, "did you mean 'fore'?"},
      {identify + Words{"--test", rec, "--signs", "some"}, "--signs"},
      {{"diagnose", "planar-2r", "--train", rec, "--test", rec, "--effects", "backlsh"},
       "did you mean 'backlash'?"},
      {{"diagnose", "planar-2r", "--train", rec, "--test", rec, "--effects", "backlash:elbw"},
       "--effects: cause 'backlash:elbw': found the joint 'elbw' (did you mean 'elbow'?)"},
      {{"payload", "planar-2r", "--recording", rec, "--link", "for"}, "did you mean 'fore'?"},
      {{"export", "planar-2r", "--dvrk-gravity", out, "--dvrk-arm", "PSM9"}, "--dvrk-arm: "},
      {simulate + Words{"--effect", "backlsh:1"}, "did you mean 'backlash'?"},
      {simulate + Words{"--effect", "backlash:3"}, "found the joint '3'"},
      {simulate + Words{"--effect", "payload:hand"}, "found the frame 'hand'"},
      {simulate + Words{"--sample-rate", "1e12"}, "--sample-rate: "},
      {simulate + Words{"--sample-rate", "0.01"}, "two rows at least"},
      {{"kinematics", "planar-2r", "--inverse", "0.5,0,0", "--start", "1"},
       "--start: found 1 joints, expected the 2 of planar-2r"},
      {{"check", rec, "--units", "tau9=-Nm"}, "--units: found 'tau9', but " + rec + " has 2 joints."},
      {identify + Words{"--units", "q3=deg"}, "--units: found 'q3', but " + rec + " has 2 joints."},
      {identify + Words{"--topic", "x"}, "--topic: means nothing here, " + rec + " is a plain table"},
      {{"check", "planar-2r", rec, "--topic", "x"}, "--topic: means nothing here"},
      {pid + Words{"--kp", "1"}, "--kp: found 1 numbers, expected 2"},
      {pid + Words{"--kp", "-1,1"}, "--kp: found -1"},
      {pid + Words{"--torque-limit", "0,1"}, "--torque-limit: found 0"},
      {pid + Words{"--control-rate", "1e12"}, "--control-rate: "},
      {{"simulate", "planar-2r", "--quiet", "--replay", rec, "--breakaway", "wrist"},
       "--breakaway: "},
      {excite + Words{"--duration", "1e12"}, "found a duration of 1e+12"},
      {excite + Words{"--box", "hand:0,1,0,1,0,1"}, "found the frame 'hand'"},
      {excite + Words{"--between", "payload:hand,torque_gain:1"}, "found the frame 'hand'"},
      {excite + Words{"--criterion", "discriminate"}, "needs --between"},
      {{"dvrk", "config", "--arm", "PSM9"}, "did you mean 'PSM1'?"},
      {emulate + Words{"--arm", "PSM9"}, "did you mean 'PSM1'?"},
      {psm1 + Words{"--instrument", "scissors"}, "--instrument: "},
      {psm1 + Words{"--event", "reboot:3@1"}, "board 3 is not emulated"},
      {psm1 + Words{"--model", "planar-2r", "--start", "1"}, "--start: found 1 numbers"},
      {psm1 + Words{"--model", "planar-2r", "--start", "9,0", "--config-out", out},
       "--start: found 9 for shoulder"},
      {emulate + Words{"--config", io, "--robot", "PSM2"}, "--robot: found 'PSM2'"},
      {emulate + Words{"--config", io, "--arm", "PSM2"}, "--arm: found PSM2, but the robot"},
  };
  for (const auto& one : cases) expect_usage_error(one.words, one.says);
  EXPECT_EQ(folder.files(), (Words{"io.xml", "rec.csv"}));
}

}  // namespace
}  // namespace veridyn
