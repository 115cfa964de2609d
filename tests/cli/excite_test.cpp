#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

#include "cli/tool.hpp"
#include "support/browser.hpp"
#include "veridyn/excitation/excitation.hpp"
#include "veridyn/recordings/recording.hpp"

namespace veridyn {
namespace {

const Words kQuick = {"--starts", "2", "--iterations", "30", "--quiet"};

TEST(Excite, WritesMotionCoefficientsAndMargins) {
  const TemporaryFolder folder;
  const ToolRun run =
      run_tool(Words{"excite", "psm-3dof", "-o", folder.path("m.csv"), "--json",
                     folder.path("m.json"), "--coefficients", folder.path("m.yaml"),
                     "--criterion", "condition"} +
               kQuick);
  ASSERT_EQ(run.status, 0) << run.err;
  std::istringstream csv(content_of(folder.path("m.csv")));
  std::string header;
  std::getline(csv, header);
  EXPECT_EQ(header, "t,q1,q2,q3,dq1,dq2,dq3,ddq1,ddq2,ddq3");
  const nlohmann::json out = json_of(folder.path("m.json"));
  EXPECT_EQ(out["status"], "done");

  EXPECT_LT(out["condition_number"], out["start_condition_number"]);
  EXPECT_EQ(out["margins"].size(), 9U);
  ASSERT_EQ(out["used"].size(), 3U);
  for (const auto& used : out["used"]) {
    EXPECT_GT(used["range"], 0.0);
    EXPECT_LE(used["range"], 1.0);
    EXPECT_LE(used["velocity"], 0.98 + 1e-9);
    EXPECT_TRUE(used["effort"].is_null());  // its torques are not known
  }
  for (const auto& margin : out["margins"]) EXPECT_GE(margin["margin"], 0.0) << margin;
  const std::string yaml = content_of(folder.path("m.yaml"));
  EXPECT_NE(yaml.find("  - name: insertion\n    q0: "), std::string::npos) << yaml;
}

// Predicted deviations follow the noise of a recording of the arm; without one they are those of
// real arms, which leave more than this simulated one.
TEST(Excite, EstimatesTheNoiseFromARecording) {
  const TemporaryFolder folder;
  const Words quick = kQuick + Words{"--duration", "16", "--rate", "100"};
  const std::string motion = folder.path("m.csv"), recording = folder.path("rec.csv"), out = folder.path("e.json");
  const Words excite = {"excite", "planar-2r", "-o", motion, "--json", out};
  ASSERT_EQ(run_tool(excite + quick).status, 0);
  const nlohmann::json usual = json_of(out)["prediction"]["noise"];
  for (const auto& share : usual["share_of_rms_torque"]) EXPECT_NEAR(share, kUsualResidual, 1e-9);
  ASSERT_EQ(run_tool({"simulate", "planar-2r", "--trajectory", motion, "-o", recording, "--noise", "low", "--quiet"}).status, 0);
  const ToolRun run = run_tool(excite + quick + Words{"--noise-of", recording});
  ASSERT_EQ(run.status, 0) << run.err;
  const nlohmann::json learned = json_of(out)["prediction"]["noise"];
  EXPECT_NE(learned["source"].get<std::string>().find(recording), std::string::npos) << learned;
  for (const auto& share : learned["share_of_rms_torque"]) {
    EXPECT_GT(share, 1e-4);
    EXPECT_LT(share, 0.02);  // of white and coloured noise of 0.5 and 0.2 %
  }
  EXPECT_EQ(run_tool(excite + quick + Words{"--noise-of", recording, "--torque-noise", "0.1"}).status, 2);
  const ToolRun short_one = run_tool(excite + quick + Words{"--noise-of", recording, "--rows", "0:10"});
  EXPECT_EQ(short_one.status, 4) << short_one.err;
  EXPECT_EQ(short_one.error_lines(), 1) << short_one.err;
}

// What was asked to be kept clear of is kept, or there is no file.
TEST(Excite, AnObstacleThatEveryPostureTouchesIsRefused) {
  const TemporaryFolder folder;
  const std::string motion = folder.path("m.csv");
  const Words arm = Words{"excite", "elbow-6r", "-o", motion, "--link-radius", "0.05"} + kQuick;
  for (const Words& hopeless : {Words{"--floor", "1.5"}, Words{"--keep-out", "-2,2,-2,2,-2,2"}}) {
    const ToolRun run = run_tool(arm + hopeless);
    EXPECT_EQ(run.status, 4) << hopeless[0];
    EXPECT_EQ(run.error_lines(), 1) << run.err;
    EXPECT_NE(run.err.find("touch at every posture"), std::string::npos) << run.err;
    EXPECT_FALSE(std::filesystem::exists(motion)) << hopeless[0];
  }
}

// Ctrl-C keeps the best motion so far, and a script sees that the search did not end by itself.
TEST(Excite, AnInterruptExitsWithStatus130) {
  const TemporaryFolder folder;
  const std::string motion = folder.path("m.csv");
  int from_tool[2];
  ASSERT_EQ(::pipe(from_tool), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    ::dup2(from_tool[1], STDERR_FILENO);
    ::dup2(from_tool[1], STDOUT_FILENO);
    ::close(from_tool[0]);
    ::execl(VERIDYN_TOOL, VERIDYN_TOOL, "excite", "planar-2r", "-o", motion.c_str(), "--starts", "50000",
            static_cast<char*>(nullptr));
    ::_exit(127);
  }
  ::close(from_tool[1]);
  std::string told;
  char some[512];
  // Once a criterion is told, there is a motion within the limits.
  for (ssize_t n; told.find("criterion") == std::string::npos && (n = ::read(from_tool[0], some, sizeof some)) > 0;)
    told.append(some, static_cast<std::size_t>(n));
  ::kill(child, SIGINT);
  while (::read(from_tool[0], some, sizeof some) > 0) {
  }
  ::close(from_tool[0]);
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status)) << told;
  EXPECT_EQ(WEXITSTATUS(status), 130) << told;
  EXPECT_EQ(read_recording(motion).joints(), 2);
}

// Killed after its first finished search, the same command writes what it would have written.
TEST(Excite, AKilledSearchResumes) {
  const TemporaryFolder folder;
  const std::string kept = folder.path("searches");
  const auto command = [&](const std::string& out) {
    return Words{"excite", "planar-2r", "-o", folder.path(out), "--starts", "4", "--iterations", "60", "--threads", "1", "--quiet"};
  };
  const auto finished = [&] {
    const std::string text = std::filesystem::exists(kept) ? content_of(kept) : "";
    return std::count(text.begin(), text.end(), '\n') - 1;
  };
  ASSERT_EQ(run_tool(command("whole.csv")).status, 0);
  Words resumed = command("m.csv") + Words{"--resume", kept};
  const pid_t child = ::fork();
  if (child == 0) {
    std::vector<char*> words = {const_cast<char*>(VERIDYN_TOOL)};
    for (std::string& word : resumed) words.push_back(word.data());
    words.push_back(nullptr);
    ::execv(VERIDYN_TOOL, words.data());
    ::_exit(127);
  }
  while (finished() < 1 && ::waitpid(child, nullptr, WNOHANG) == 0) ::usleep(500);
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  const std::string before = content_of(kept);
  ASSERT_GE(finished(), 1);
  std::ofstream(kept, std::ios::app) << "3 1 1 7";  // a line that the kill cut short
  const ToolRun again = run_tool(resumed);
  ASSERT_EQ(again.status, 0) << again.err;
  EXPECT_EQ(content_of(kept).rfind(before, 0), 0U);
  EXPECT_EQ(finished(), 4 + 1);
  EXPECT_EQ(content_of(folder.path("m.csv")), content_of(folder.path("whole.csv")));
  const ToolRun other = run_tool(resumed + Words{"--seed", "2"});
  EXPECT_EQ(other.status, 3);
  EXPECT_NE(other.err.find("searches:1: found"), std::string::npos) << other.err;
  EXPECT_EQ(other.error_lines(), 1);
}

// A motion of marked searches: what is kept is taken, not searched again.
TEST(Excite, AFinishedSearchIsReused) {
  const TemporaryFolder folder;
  const std::string kept = folder.path("searches");
  const Words command = {"excite", "planar-2r", "-o", folder.path("m.csv"), "--starts", "1", "--iterations", "30", "--quiet",
                         "--resume", kept};
  ASSERT_EQ(run_tool(command + Words{"--json", folder.path("a.json")}).status, 0);
  std::string text = content_of(kept);
  const std::size_t line = text.find('\n') + 1;  // start, cost, converged, evaluations
  std::size_t at = line;
  for (int word = 0; word < 3; ++word) at = text.find(' ', at) + 1;
  text.replace(at, text.find(' ', at) - at, "123456");
  folder.write("searches", text);
  ASSERT_EQ(run_tool(command + Words{"--json", folder.path("b.json")}).status, 0);
  EXPECT_EQ(json_of(folder.path("b.json"))["evaluations"], 123456);
  EXPECT_NE(json_of(folder.path("a.json"))["evaluations"], 123456);
  // A damaged line is searched again, and so is one of lists that no such search has; the new line is then taken.
  for (const std::string damaged : {"1234x6", "7 9999"}) {
    std::string other = text;
    folder.write("searches", other.replace(at, 6, damaged));
    for (const bool first : {true, false}) {
      ASSERT_EQ(run_tool(command + Words{"--json", folder.path("b.json")}).status, 0) << damaged;
      EXPECT_EQ(json_of(folder.path("b.json"))["evaluations"], json_of(folder.path("a.json"))["evaluations"]) << damaged << first;
    }
    const std::string lines = content_of(kept);
    EXPECT_EQ(std::count(lines.begin(), lines.end(), '\n'), 3) << damaged;
  }
}

// Read as a file, a device without an end would be read for ever.
TEST(Excite, RefusesToResumeFromADevice) {
  const TemporaryFolder folder;
  const ToolRun run = run_tool({"excite", "planar-2r", "-o", folder.path("m.csv"), "--quiet", "--resume", "/dev/zero"}, "", 60);
  EXPECT_EQ(run.status, 3) << run.err;
  EXPECT_EQ(run.error_lines(), 1) << run.err;
  EXPECT_NE(run.err.find("/dev/zero: found a folder, a pipe or a device"), std::string::npos) << run.err;
}

TEST(Excite, TheSameSeedWritesTheSameFile) {
  const TemporaryFolder folder;
  for (const char* threads : {"1", "2"}) {
    const ToolRun run = run_tool(Words{"excite", "psm-3dof", "-o", folder.path(threads), "--seed",
                                       "3", "--threads", threads} +
                                 kQuick);
    ASSERT_EQ(run.status, 0) << run.err;
  }
  EXPECT_EQ(content_of(folder.path("1")), content_of(folder.path("2")));
}

TEST(Excite, InfeasibleLimitsAreReportedAndNoFileIsWritten) {
  const TemporaryFolder folder;
  const ToolRun run = run_tool(Words{"excite", "psm-3dof", "-o", folder.path("m.csv"), "--box",
                                     "tool:5,6,-inf,inf,-inf,inf"} +
                               kQuick);
  EXPECT_EQ(run.status, 4);
  EXPECT_NE(run.err.find("x of tool must stay within 5 .. 6 m"), std::string::npos) << run.err;
  EXPECT_EQ(run.error_lines(), 1);
  EXPECT_TRUE(folder.files().empty());
}

TEST(Excite, LinksStayAboveTheFloorUnlessCollisionChecksAreOff) {
  const TemporaryFolder folder;
  const Words arm = {"excite", "elbow-6r", "-o", folder.path("m.csv"), "--json", folder.path("m.json"), "--link-radius", "0.05",
                     "--criterion", "d-optimal", "--harmonics", "3", "--starts", "1", "--iterations", "5", "--quiet"};
  const ToolRun run = run_tool(arm + Words{"--floor", "-0.2"});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.out.find("gap of column and floor"), std::string::npos) << run.out;
  int gaps = 0;
  const nlohmann::json with_floor = json_of(folder.path("m.json"));
  for (const auto& margin : with_floor["margins"]) {
    if (margin["limit"].get<std::string>().rfind("gap of ", 0) != 0) continue;
    ++gaps;
    EXPECT_GE(margin["margin"], 0.0) << margin;
  }
  EXPECT_GT(gaps, 5);
  const ToolRun off = run_tool(Words{"excite", "elbow-6r", "-o", folder.path("m.csv"), "--json", folder.path("m.json"), "--collisions", "off",
                                     "--starts", "1", "--iterations", "2", "--harmonics", "3", "--quiet"});
  ASSERT_EQ(off.status, 0) << off.err;
  EXPECT_EQ(content_of(folder.path("m.json")).find("gap of "), std::string::npos);
  for (const Words& wrong : {Words{"--collisions", "off", "--floor", "0"}, Words{"--floor", "0"}, Words{"--keep-out", "0,1,0,1"},
                             Words{"--link-radius", "0.1", "--keep-out", "1,0,0,1,0,1"}, Words{"--link-radius", "-1"}}) {
    const ToolRun refused = run_tool(Words{"excite", "elbow-6r", "-o", folder.path("m.csv")} + wrong);
    EXPECT_EQ(refused.status, 2) << wrong.front();
    EXPECT_EQ(refused.error_lines(), 1) << refused.err;
  }
}

TEST(Excite, TheSeparableShareOfTwoCausesIsReported) {
  const TemporaryFolder folder;
  const ToolRun run =
      run_tool(Words{"excite", "psm-3dof", "-o", folder.path("m.csv"), "--json",
                     folder.path("m.json"), "--between", "payload:tool,torque_gain:2"} +
               kQuick);
  ASSERT_EQ(run.status, 0) << run.err;
  const nlohmann::json out = json_of(folder.path("m.json"))["discrimination"];
  EXPECT_TRUE(out["bodies_known"]);
  for (const double share : out["share_left"]) {
    EXPECT_GT(share, 0.2);
    EXPECT_LE(share, 1.0 + 1e-9);
  }
}

// Every number of the page's text is in the JSON, the plots are drawn, and nothing fails.
TEST(Excite, EveryNumberOfThePageIsInTheJson) {
  if (browser().empty()) GTEST_SKIP() << "no browser: chromium is not installed";
  const TemporaryFolder folder;
  const ToolRun run = run_tool(Words{"excite", "psm-3dof", "-o", folder.path("m.csv"), "--report",
                                     folder.path("m.html"), "--json", folder.path("m.json"),
                                     "--box", "tool:-1,1,-1,1,-inf,1", "--slow-passes", "1"} +
                               kQuick);
  ASSERT_EQ(run.status, 0) << run.err;
  const nlohmann::json result = json_of(folder.path("m.json"));
  EXPECT_EQ(result["prediction"]["base_parameters"].size(), result["base_parameters"]);
  const std::vector<OpenedPage> opened = open_pages({{folder.path("m.html"), 400}, {folder.path("m.html"), 1200}});
  for (const OpenedPage& page : opened) {
    expect_faultless(page, &page == &opened[0] ? 400 : 1200);
    std::map<std::string, int> kinds;
    for (const PageElement& plot : page.with("data-plot")) ++kinds[plot.at("data-plot")];
    EXPECT_EQ(kinds["error"], 3 * 3);  // position, velocity and acceleration of three joints
    EXPECT_EQ(kinds["arm"], 1);
    EXPECT_EQ(kinds["used"], 1);
    const auto numbers = page.with("data-from");
    EXPECT_GT(numbers.size(),
              4U * result["margins"].size() + 3U * result["base_parameters"].get<size_t>());
    for (const PageElement& n : numbers) {
      if (n.at("data-from") != "/frequency") expect_number(n, result);  // shown as a period
    }
    EXPECT_EQ(page.html.find("[object"), std::string::npos);
  }
}

// The prediction speaks of the base parameters that an identification lists.
TEST(Excite, RelativeDeviationsAndEssentialParametersAreInTheFile) {
  const TemporaryFolder folder;
  const auto path = [&](const char* name) { return folder.path(name); };
  const ToolRun run =
      run_tool(Words{"excite", "psm-3dof", "-o", path("m.csv"), "--json", path("m.json"),
                     "--criterion", "a-optimal", "--essential", "0.1"} +
               kQuick);
  ASSERT_EQ(run.status, 0) << run.err;
  const nlohmann::json out = json_of(path("m.json"));
  EXPECT_EQ(out["criterion"], "a-optimal");
  EXPECT_EQ(out["base"].size(), 25U);
  EXPECT_EQ(out["essential"]["count"], 24);
  ASSERT_EQ(out["essential"]["left_out"].size(), 1U);
  EXPECT_LT(out["essential"]["left_out"][0]["share"], 0.1);
  EXPECT_LT(out["essential"]["condition_number"], out["condition_number"]);
  ASSERT_EQ(run_tool({"simulate", "psm-3dof", "--trajectory", path("m.csv"), "-o", path("r.csv"),
                      "--quiet"})
                .status,
            0);
  const ToolRun identify = run_tool({"identify", "psm-3dof", "--train", path("r.csv"), "--method",
                                     "wls", "--json", path("i.json"), "--quiet"});
  ASSERT_EQ(identify.status, 0) << identify.err;
  const nlohmann::json identified = json_of(path("i.json"))["base_parameters"];
  const nlohmann::json predicted = out["prediction"]["base_parameters"];
  ASSERT_EQ(identified.size(), predicted.size());
  for (size_t b = 0; b < identified.size(); ++b)
    EXPECT_EQ(identified[b]["name"].get<std::string>(), predicted[b]["name"].get<std::string>());
}

TEST(Excite, SlowPassesExtendTheFileByTheirDuration) {
  const TemporaryFolder folder;
  const ToolRun run = run_tool(Words{"excite", "psm-3dof", "-o", folder.path("m.csv"), "--json",
                                     folder.path("m.json"), "--slow-passes", "2"} +
                               kQuick);
  ASSERT_EQ(run.status, 0) << run.err;
  const nlohmann::json out = json_of(folder.path("m.json"));
  EXPECT_GT(out["slow_seconds"], 30.0);
  const std::string csv = content_of(folder.path("m.csv"));
  const double last = std::stod(csv.substr(csv.rfind('\n', csv.size() - 2) + 1));
  EXPECT_NEAR(last, out["duration"].get<double>() + out["slow_seconds"].get<double>(), 0.02);
}

// What is recorded with noisy velocities counts as what it is: half of the information is there
// already, and not more.
TEST(Excite, NoisyVelocitiesOfAGivenRecordingAddNoInformation) {
  const TemporaryFolder folder;
  const auto path = [&](const char* name) { return folder.path(name); };
  ASSERT_EQ(run_tool(Words{"excite", "psm-3dof", "-o", path("m.csv")} + kQuick).status, 0);
  ASSERT_EQ(run_tool({"simulate", "psm-3dof", "--trajectory", path("m.csv"), "-o", path("r.csv"),
                      "--noise", "dvrk", "--quiet"})
                .status,
            0);
  const auto median = [&](const Words& more) {
    // A random motion: the same whatever is given.
    const ToolRun run =
        run_tool(Words{"excite", "psm-3dof", "-o", path("n.csv"), "--json", path("n.json"),
                       "--solver", "random", "--iterations", "1", "--starts", "1", "--quiet"} +
                 more);
    EXPECT_EQ(run.status, 0) << run.err;
    return json_of(path("n.json"))["prediction"]["median_relative_std"].get<double>();
  };
  const double exact = median({"--given", path("m.csv")});
  EXPECT_NEAR(median({"--given", path("r.csv")}) / exact, 1.0, 0.15);
  // However the file says it, and no more of it than asked.
  std::string other = content_of(path("m.csv"));
  other.replace(0, 1, "stamp");
  folder.write("o.csv", other);
  EXPECT_EQ(median({"--given", path("o.csv"), "--map", "t=stamp"}), exact);
  EXPECT_GT(median({"--given", path("m.csv"), "--rows", "0:600"}), 1.02 * exact);
  EXPECT_LT(median({"--given", path("m.csv"), "--units", "tau=Nm,q=rad"}), 1.02 * exact);
  EXPECT_GT(median({}), 1.1 * exact);
}

// Recordings are checked as those of `identify` are.
TEST(Excite, GivenRecordingsInAnotherUnitAreWarnedOf) {
  const TemporaryFolder folder;
  const std::string given = folder.write("given.csv", planar_recording(20.0));
  const Words excite = Words{"excite", "planar-2r", "-o", folder.path("m.csv"), "--given", given, "--iterations", "5", "--starts", "1"} + Words{"--quiet"};
  const ToolRun right = run_tool(excite);
  EXPECT_EQ(right.status, 0) << right.err;
  EXPECT_EQ(right.err.find("warning: " + given), std::string::npos) << right.err;
  const ToolRun wrong = run_tool(excite + Words{"--units", "q=deg"});
  EXPECT_NE(wrong.err.find("warning: " + given), std::string::npos) << wrong.err;
}

TEST(Excite, RangesInDegreesAreRefused) {
  const TemporaryFolder folder;
  std::string robot = content_of(std::string(VERIDYN_SOURCE_DIR) + "/data/robots/planar-2r.yaml");
  for (size_t at = 0; (at = robot.find("[-2.5, 2.5]", at)) != std::string::npos;) robot.replace(at, 11, "[-143, 143]");
  const std::string file = folder.write("degrees.yaml", robot);
  const ToolRun run = run_tool({"excite", file, "-o", folder.path("m.csv"), "--quiet"});
  EXPECT_EQ(run.status, 3);
  EXPECT_EQ(run.error_lines(), 1) << run.err;
  EXPECT_NE(run.err.find("found the ranges shoulder -143 to 143, elbow -143 to 143, all beyond two turns"), std::string::npos) << run.err;
  EXPECT_FALSE(std::filesystem::exists(folder.path("m.csv")));
}

TEST(Excite, AFixedJointIsLeftOutOfTheMotion) {
  const TemporaryFolder folder;
  const Words held = Words{"excite", "planar-2r", "-o", folder.path("m.csv")} + kQuick;
  const ToolRun run = run_tool(held + Words{"--fix", "elbow=0.3"});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(content_of(folder.path("m.csv")).rfind("t,q1,dq1,ddq1\n", 0), 0U);
  for (const Words& option : std::vector<Words>{{"--units", "q=deg"}, {"--rows", "0:9"}, {"--topic", "x"}}) {
    const ToolRun refused = run_tool(held + option);
    EXPECT_EQ(refused.status, 2) << option[0];
    EXPECT_NE(refused.err.find(option[0] + ": means nothing here, it needs --given"), std::string::npos)
        << refused.err;
  }
}

// What `diagnose` prints as the next experiment is a command that runs as it stands, and its
// recording settles the question.
TEST(Excite, TheMotionThatDiagnosePrintsSeparatesItsTwoCauses) {
  const TemporaryFolder folder;
  const auto path = [&](const std::string& name) { return folder.path(name); };
  const auto record = [&](const std::string& motion, const std::string& seed) {
    const std::string recording = path("recording" + seed + ".csv");
    EXPECT_EQ(run_tool({"simulate", "psm-3dof", "--trajectory", motion, "-o", recording, "--effect",
                        "load_dependent_friction:yaw:coefficient=0.05", "--noise", "dvrk", "--seed",
                        seed, "--quiet"})
                  .status,
              0);
    std::string rows = content_of(recording);
    EXPECT_EQ(rows.rfind("t,", 0), 0U);
    folder.write("recording" + seed + ".csv", rows.replace(0, 1, "stamp"));
    return recording;
  };
  // Motions that go half as far as they could: where the load hardly changes.
  std::vector<std::string> recordings;
  for (const char* seed : {"3", "5"}) {
    ASSERT_EQ(
        run_tool({"excite", "psm-3dof", "-o", path(seed), "--solver", "random", "--iterations", "1",
                  "--starts", "1", "--limit-share", "0.5", "--seed", seed, "--quiet"})
            .status,
        0);
    recordings.push_back(record(path(seed), seed));
  }
  const auto diagnosis = [&](const Words& train) {
    EXPECT_EQ(run_tool(Words{"diagnose", "psm-3dof", "--train"} + train +
                       Words{"--test", recordings[1], "--map", "t=stamp", "--json", path("why.json"), "--model-out",
                             path("model.yaml"), "--quiet"})
                  .status,
              0);
    return json_of(path("why.json"));
  };
  const nlohmann::json before = diagnosis({recordings[0]});
  ASSERT_EQ(before["findings"].size(), 1U);
  EXPECT_EQ(before["findings"][0]["effect"], "load_dependent_friction");
  const ToolRun excite = run_tool({"excite", "psm-3dof", "-o", path("next.csv"), "--criterion", "discriminate", "--between",
                                   "load_dependent_friction:yaw,position_dependent_friction:yaw", "--given", recordings[0], "--map",
                                   "t=stamp", "--quiet"});
  ASSERT_EQ(excite.status, 0) << excite.err;
  const nlohmann::json after = diagnosis({recordings[0], record(path("next.csv"), "4")});
  ASSERT_FALSE(after["findings"].empty());
  EXPECT_EQ(after["findings"][0]["effect"], "load_dependent_friction");
  EXPECT_EQ(after["findings"][0]["joint"], 1);
  EXPECT_TRUE(after["findings"][0]["rivals"].empty()) << after["findings"][0]["rivals"];
  for (const auto& finding : after["findings"])
    EXPECT_NE(finding["effect"], "position_dependent_friction") << finding;
}

// A solver that is named is the one that searches, or it is refused.
TEST(Excite, TheNamedSolverIsUsedOrRefused) {
  const TemporaryFolder folder;
  for (const ExcitationSolver solver :
       {ExcitationSolver::kInteriorPoint, ExcitationSolver::kIpopt, ExcitationSolver::kNlopt}) {
    const std::string name = name_of(solver);
    const std::string motion = folder.path(name + ".csv");
    const std::string out = folder.path(name + ".json");
    const ToolRun run = run_tool({"excite", "planar-2r", "-o", motion, "--solver", name, "--criterion", "condition",
                                  "--iterations", "60", "--starts", "1", "--json", out});
    if (!is_built_in(solver)) {
      EXPECT_EQ(run.status, 2) << run.err;
      EXPECT_NE(run.err.find(name), std::string::npos) << run.err;
      EXPECT_FALSE(std::ifstream(motion).good()) << "a refused search writes nothing";
      continue;
    }
    ASSERT_EQ(run.status, 0) << run.err;
    EXPECT_EQ(json_of(out)["solver"], name);
    // Random motions of this arm and seed reach 5.5 at best; all three find what is near 3.
    EXPECT_LT(json_of(out)["condition_number"], 4.0) << name;
  }
}

TEST(Excite, MalformedOptionsAreUsageErrors) {
  const TemporaryFolder folder;
  const Words base = {"excite", "psm-3dof", "-o", folder.path("m.csv")};
  for (const Words& wrong : std::vector<Words>{{"--between", "payload"},
                                               {"--box", "tool:1,2"},
                                               {"--sphere", "tool:-1"},
                                               {"--obstacle", "1,2,3"},
                                               {"--insertion", "tool"},
                                               {"--solver", "snopt"}}) {
    const ToolRun run = run_tool(base + wrong);
    EXPECT_EQ(run.status, 2) << wrong[0] << run.err;
    EXPECT_EQ(run.error_lines(), 1) << run.err;
  }
  EXPECT_EQ(run_tool(base + Words{"--box", "nowhere:0,1,0,1,0,1"}).status, 2);
  EXPECT_TRUE(folder.files().empty());
}

}  // namespace
}  // namespace veridyn
