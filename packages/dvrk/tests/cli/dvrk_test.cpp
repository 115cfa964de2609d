#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>
#include <thread>

#include "cli/tool.hpp"
#include "veridyn/recordings/recording.hpp"

// `veridyn dvrk`: emulated boards in one process, their client in another, over loopback, in real
// time.

namespace veridyn {
namespace {

using nlohmann::json;

// Two motors for planar-2r on board 6; the second is mounted reversed.
std::string io_xml() {
  std::ostringstream out;
  out.precision(17);
  out << "<?xml version=\"1.0\"?>\n<Config Version=\"5\">\n"
         "<Robot Name=\"planar\" HardwareVersion=\"QLA1\" NumOfActuator=\"2\" SN=\"1\">\n";
  for (int k = 0; k < 2; ++k) {
    const double s = k == 0 ? 1.0 : -1.0;
    out << "<Actuator ActuatorID=\"" << k << "\" BoardID=\"6\" AxisID=\"" << k
        << "\" Type=\"Revolute\">\n<Drive><AmpsToBits Scale=\"" << s * 5242.88 << "\" Offset=\""
        << 32808 + 40 * k << "\"/><BitsToFeedbackAmps Scale=\"" << s * 12.5 / 65536
        << "\" Offset=\"" << -s * 6.25
        << "\"/><NmToAmps Scale=\"0.06\"/><MaxCurrent Value=\"5.0\" Unit=\"A\"/></Drive>\n"
        << "<Encoder VelocitySource=\"FIRMWARE\"><BitsToPosSI Scale=\"" << s * 360 / (14400 * 56.5)
        << "\" Unit=\"deg\"/><PositionLimitsSoft Lower=\"-143\" Upper=\"143\" Unit=\"deg\"/>"
        << "</Encoder>\n<AnalogIn><BitsToVolts Scale=\"6.866455078125e-05\" Offset=\"0\"/>"
        << "<VoltsToPosSI Scale=\"" << s * 70 << "\" Offset=\"" << -s * 157
        << "\" Unit=\"deg\"/></AnalogIn>\n</Actuator>\n";
  }
  out << "</Robot>\n</Config>\n";
  return out.str();
}

std::string with_replaced(std::string text, const std::string& old, const std::string& now) {
  for (auto at = text.find(old); at != std::string::npos; at = text.find(old, at + now.size()))
    text.replace(at, old.size(), now);
  return text;
}

// `veridyn dvrk emulate` as a process of its own.
class Boards {
 public:
  Boards(Words words, const std::string& out) {
    words = Words{VERIDYN_TOOL, "dvrk", "emulate", "--port", "0", "--quiet"} + words;
    child_ = ::fork();
    if (child_ == 0) {
      if (std::freopen(out.c_str(), "w", stdout) == nullptr) ::_exit(126);
      std::vector<char*> argv;
      for (std::string& word : words) argv.push_back(word.data());
      argv.push_back(nullptr);
      ::execv(argv[0], argv.data());
      ::_exit(127);
    }
    for (int k = 0; k < 1000 && port_.empty(); ++k) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      const std::string said = content_of(out);
      const auto at = said.find("port ");
      if (said.find('\n') != std::string::npos && at != std::string::npos)
        port_ = said.substr(at + 5, said.find(',', at) - at - 5);
    }
  }
  ~Boards() {
    if (child_ <= 0) return;
    ::kill(child_, SIGTERM);
    ::waitpid(child_, nullptr, 0);
  }
  Boards(const Boards&) = delete;
  Boards& operator=(const Boards&) = delete;

  const std::string& port() const { return port_; }

 private:
  pid_t child_ = -1;
  std::string port_;
};

// A busy machine may suspend the tool for longer than a watchdog allows. The tool's message
// distinguishes this from every other end of a run.
bool ended_by_the_clock(const ToolRun& run) {
  if (run.status != 4) return false;
  for (const char* words : {"too busy", "is late", "was late", "watchdog", "took too long", "no reply in time", "lost or late"}) {
    if (run.err.find(words) != std::string::npos) return true;
  }
  return false;
}

// Three attempts on a busy machine; other errors fail at once.
ToolRun run_when_calm(const Words& words) {
  ToolRun run;
  for (int attempt = 0; attempt < 3; ++attempt) {
    run = run_tool(words);
    if (!ended_by_the_clock(run)) break;
  }
  return run;
}

class Dvrk : public testing::Test {
 protected:
  std::string config() { return folder_.write("io.xml", io_xml()); }
  Words client(const std::string& command, const Boards& boards) {
    return {"dvrk", command, "--config", config(), "--port", boards.port(), "--watchdog", "0.3"};
  }
  // On boards in the tool itself, whose clock does not depend on the machine.
  Words rehearse() { return {"dvrk", "run", "--config", config(), "--emulate", "--model", "planar-2r"}; }
  TemporaryFolder folder_;
};

// Identifies from a recording, and holds the result against data/robots/planar-2r.yaml.
void expect_planar_arm(const std::string& recording) {
  const std::string path = recording + ".json";
  const ToolRun run =
      run_tool({"identify", "planar-2r", "--train", recording, "--json", path, "--quiet"});
  ASSERT_EQ(run.status, 0) << run.err;
  // Values of data/robots/planar-2r.yaml: rods of 4 kg, 0.5 m and 2.5 kg, 0.4 m.
  const std::map<std::string, double> truth = {{"viscous_friction(shoulder)", 0.8},
                                               {"coulomb_friction(shoulder)", 1.2},
                                               {"viscous_friction(elbow)", 0.4},
                                               {"coulomb_friction(elbow)", 0.6},
                                               {"hx_upper", -1.0 + 0.5 * 6.5},
                                               {"hx_fore", -0.5 + 0.4 * 2.5},
                                               {"hy_upper", 0.0},
                                               {"hy_fore", 0.0}};
  int found = 0, inside = 0;
  const json identified = json_of(path);
  for (const json& parameter : identified["base_parameters"]) {
    const std::string expression = parameter["expression"];
    for (const auto& [name, value] : truth) {
      if (expression.rfind(name, 0) != 0) continue;
      const double off = std::abs(parameter["value"].get<double>() - value);
      const double sigma = parameter["std"].get<double>();
      EXPECT_LT(off, 5.0 * sigma) << expression;
      inside += off < 1.96 * sigma ? 1 : 0;
      ++found;
      break;
    }
  }
  EXPECT_EQ(found, 8);
  EXPECT_GE(inside, 6);
}

// From an experiment that was designed to a model that was identified, through boards that move a
// simulated arm: the identified values are the simulated ones.
TEST_F(Dvrk, TheRecordingOfARunIdentifiesTheArmBehindTheBoards) {
  const std::string trajectory = folder_.path("traj.csv");
  ToolRun run = run_tool({"excite", "planar-2r", "-o", trajectory, "--duration", "6", "--frequency",
                          "0.34", "--harmonics", "3", "--quiet"});
  ASSERT_EQ(run.status, 0) << run.err;
  for (const char* controller : {"pid", "computed-torque"}) {
    SCOPED_TRACE(controller);
    const std::string recording = folder_.path(std::string(controller) + ".csv");
    run = run_tool(rehearse() + Words{"--trajectory", trajectory, "-o", recording, "--approach-speed", "1",
                                      "--rate", "500", "--controller", controller});
    ASSERT_EQ(run.status, 0) << run.err;
    expect_planar_arm(recording);
  }
}

// User gains: the law's default gains change nothing, weaker ones let the arm lag.
TEST_F(Dvrk, GainsFromAFileChangeTheMotion) {
  const std::string trajectory = folder_.path("traj.csv");
  std::ofstream motion(trajectory);
  motion << "t,q1,q2,q3\n";
  for (int k = 0; k <= 20; ++k) {
    const double way = 0.5 - 0.5 * std::cos(M_PI * k / 20);
    motion << 0.05 * k << "," << 0.3 * way << "," << -0.3 * way << "," << 0.05 + 0.05 * way << "\n";
  }
  motion.close();
  const auto run_words = [&](const std::string& law) {
    return Words{"dvrk", "run", "--arm", "PSM1", "--emulate", "--trajectory", trajectory, "--rate", "500",
                 "--model", VERIDYN_SOURCE_DIR "/examples/dvrk/light-psm.yaml", "--controller", law};
  };
  const auto moved = [&](const std::string& law, const std::string& gains) {
    const std::string out = folder_.path("rec.csv");
    Words words = run_words(law) + Words{"-o", out, "--approach-speed", "1", "--largest-error", "1"};
    if (!gains.empty()) words = words + Words{"--gains", folder_.write("gains.yaml", gains)};
    const ToolRun run = run_tool(words);
    EXPECT_EQ(run.status, 0) << run.err;
    return read_recording(out).q;
  };
  const struct {
    const char *law, *same, *weak;
  } laws[] = {{"computed-torque", "p: [400, 400, 400]\nd: [40, 40, 40]\n", "p: [16, 16, 16]\n"},
              {"impedance",
               "mass: [2, 2, 2]\ndamping: [80, 80, 80]\nstiffness: [800, 800, 800]\n",
               "mass: [2, 2, 2]\ndamping: [80, 80, 80]\nstiffness: [80, 80, 80]\n"}};
  for (const auto& one : laws) {
    SCOPED_TRACE(one.law);
    const MatrixXd own = moved(one.law, "");
    const MatrixXd same = moved(one.law, one.same);
    const MatrixXd weak = moved(one.law, one.weak);
    ASSERT_EQ(own.rows(), same.rows());
    EXPECT_LT((own - same).cwiseAbs().maxCoeff(), 1e-6);
    const Eigen::Index rows = std::min(own.rows(), weak.rows());
    EXPECT_GT((own.topRows(rows) - weak.topRows(rows)).cwiseAbs().maxCoeff(), 1e-3);
  }
  const ToolRun bad = run_tool(run_words("impedance") + Words{"-o", folder_.path("r.csv"), "--gains",
                                                              folder_.write("g.yaml", "p: [1, 1]\n")});
  EXPECT_EQ(bad.status, 3);
  EXPECT_NE(bad.err.find("g.yaml:1:1: found the unknown key 'p', expected one of: mass"),
            std::string::npos)
      << bad.err;
}

// The arm of README's example: the motors of a nominal PSM1 carry and move it.
TEST_F(Dvrk, TheMotorsOfANominalPsm1MoveTheExampleArm) {
  const std::string arm = VERIDYN_SOURCE_DIR "/examples/dvrk/light-psm.yaml";
  const std::string trajectory = folder_.path("traj.csv");
  std::ofstream motion(trajectory);
  motion << "t,q1,q2,q3\n";
  for (int k = 0; k <= 40; ++k) {
    const double way = 0.5 - 0.5 * std::cos(M_PI * k / 40);
    motion << 0.05 * k << "," << 0.9 * way << "," << -0.8 * way << "," << 0.05 + 0.15 * way << "\n";
  }
  motion.close();
  for (const char* controller : {"pid", "computed-torque"}) {
    const ToolRun run = run_tool(
        Words{"dvrk", "run", "--arm", "PSM1", "--emulate", "--trajectory", trajectory, "--model", arm} +
        Words{"-o", folder_.path("rec.csv"), "--approach-speed", "1", "--rate", "500"} +
        Words{"--largest-error", "0.1", "--controller", controller});
    EXPECT_EQ(run.status, 0) << controller << ": " << run.err;
  }
}

TEST_F(Dvrk, MonitorAndReadSendNoWritesByDefault) {
  {
    const Boards boards({"--config", config(), "--model", "planar-2r", "--start", "0.5,-0.25",
                         "--pot-noise", "0", "--json", folder_.path("boards.json")},
                        folder_.path("boards.txt"));
    ToolRun run = run_when_calm(client("monitor", boards) + Words{"--seconds", "0.5"});
    ASSERT_TRUE(run.status == 0 || ended_by_the_clock(run)) << run.err;
    EXPECT_NE(run.out.find("never loaded"), std::string::npos) << run.out;
    EXPECT_NE(run.out.find("25.0 C, 26.0 C"), std::string::npos) << run.out;
    EXPECT_NE(run.out.find(" 0.4999"), std::string::npos) << run.out;  // the pot
    run = run_when_calm(client("read", boards) +
                   Words{"--seconds", "0.3", "--rate", "100", "-o", folder_.path("rest.csv")});
    EXPECT_TRUE(run.status == 0 || ended_by_the_clock(run)) << run.err;
    EXPECT_NE(run.err.find("never loaded"), std::string::npos) << run.err;
  }
  EXPECT_EQ(json_of(folder_.path("boards.json"))["writes"], 0);
  const Boards boards(
      {"--config", config(), "--model", "planar-2r", "--start", "0.5,-0.25", "--pot-noise", "0"},
      folder_.path("boards.txt"));
  ToolRun run = run_when_calm(client("monitor", boards) + Words{"--seconds", "0.5", "--home"});
  ASSERT_TRUE(run.status == 0 || ended_by_the_clock(run)) << run.err;
  EXPECT_EQ(run.out.find("never loaded"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("-0.2499"), std::string::npos) << run.out;
  const std::string recording = folder_.path("rec.csv");
  run = run_when_calm(client("read", boards) + Words{"--seconds", "0.5", "--rate", "100", "-o",
                                                recording, "--protocol", "broadcast"});
  ASSERT_TRUE(run.status == 0 || ended_by_the_clock(run)) << run.err;
  EXPECT_EQ(content_of(recording).rfind("t,q1,q2,dq1,dq2,tau1,tau2\n", 0), 0U);
}

// Amplifiers go off by the watchdog, but a supply that could not be switched off is not reported as off.
TEST_F(Dvrk, UnconfirmedPowerOffIsReportedAndExitsWithStatus4) {
  const std::string trajectory = folder_.path("traj.csv");
  std::ofstream(trajectory) << "t,q1,q2\n0,0,0\n5,0.05,0.05\n10,0.1,0.1\n15,0.05,0.1\n20,0,0\n";
  const ToolRun run = run_tool(rehearse() +
                               Words{"--event", "lose-writes@5", "--trajectory", trajectory, "-o",
                                     folder_.path("rec.csv"), "--json", folder_.path("run.json")});
  EXPECT_EQ(run.status, 4) << run.err;
  EXPECT_NE(run.err.find("NOT CONFIRMED"), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("press the emergency stop"), std::string::npos) << run.err;
  EXPECT_EQ(run.err.find("power is off"), std::string::npos) << run.err;
  EXPECT_EQ(json_of(folder_.path("run.json"))["power_off"], "not confirmed");
}

// 5 ms of every reply: 94 cycles a second in place of 1500.
TEST_F(Dvrk, APersistentlyLateLoopExitsWithStatus4) {
  const std::string trajectory = folder_.path("traj.csv");
  std::ofstream(trajectory) << "t,q1,q2\n0,0,0\n5,0.05,0.05\n10,0.1,0.1\n15,0.05,0.1\n20,0,0\n";
  const ToolRun run = run_tool(rehearse() +
                               Words{"--event", "late=0.005@1", "--trajectory", trajectory, "-o",
                                     folder_.path("rec.csv"), "--json", folder_.path("run.json")});
  EXPECT_EQ(run.status, 4) << run.err;
  EXPECT_FALSE(json_of(folder_.path("run.json"))["complete"].get<bool>());
  const bool known = run.err.find("late") != std::string::npos ||
                     run.err.find("watchdog") != std::string::npos ||
                     run.err.find("no reply in time") != std::string::npos;  // a machine that is busier
  EXPECT_TRUE(known) << run.err;
}

TEST_F(Dvrk, SeveralArmsAreEmulatedOnOneBus) {
  const Boards boards(
      {"--arm", "PSM1", "PSM2", "--model", VERIDYN_SOURCE_DIR "/examples/dvrk/light-psm.yaml",
       "--config-out", folder_.path("two.xml")},
      folder_.path("boards.txt"));
  EXPECT_NE(content_of(folder_.path("boards.txt")).find("PSM1, PSM2: 4 boards"), std::string::npos);
  for (const char* arm : {"PSM1", "PSM2"}) {
    const ToolRun run = run_tool({"dvrk", "monitor", "--config", folder_.path("two.xml"), "--robot",
                                  arm, "--port", boards.port(), "--seconds", "0.3"});
    EXPECT_EQ(run.status, 0) << run.err;
  }
}

// Commands that the page of a first dVRK run prints, word by word, on a port of its own.
Words words_of_the_page(const std::string& begin) {
  std::istringstream page(content_of(VERIDYN_SOURCE_DIR "/docs/start-dvrk.md"));
  bool here = false;
  for (std::string line; std::getline(page, line);) {
    if (line.rfind("## ", 0) == 0) here = line.find("emulated boards") != std::string::npos;
    const auto at = line.find("veridyn " + begin);
    if (!here || at == std::string::npos || line.rfind("    ", 0) != 0) continue;
    std::istringstream rest(line.substr(at, line.find_first_of("&#", at) - at));
    Words words;
    std::string word;
    rest >> word;
    while (rest >> word) words.push_back(word);
    return words;
  }
  return {};
}

TEST_F(Dvrk, TheCommandsOfTheFirstRunInTheManualSucceed) {
  const auto in_folder = [&](Words words) {
    for (std::string& word : words) {
      const bool file =
          word.size() > 4 && word.find('/') == std::string::npos &&
          (word.rfind(".csv") == word.size() - 4 || word.rfind(".xml") == word.size() - 4);
      if (file) word = folder_.path(word);
      if (word.rfind("examples/", 0) == 0) word = VERIDYN_SOURCE_DIR "/" + word;
    }
    return words;
  };
  const Words emulate = in_folder(words_of_the_page("dvrk emulate"));
  const Words excite = in_folder(words_of_the_page("excite"));
  const Words monitor = in_folder(words_of_the_page("dvrk monitor"));
  const Words drive = in_folder(words_of_the_page("dvrk run"));
  ASSERT_GT(emulate.size(), 4U);
  ASSERT_GT(excite.size(), 4U);
  ASSERT_GT(monitor.size(), 3U);
  ASSERT_GT(drive.size(), 8U);
  const Boards boards(Words(emulate.begin() + 2, emulate.end()), folder_.path("boards.txt"));
  ASSERT_NE(boards.port(), "");
  const Words port = {"--port", boards.port()};
  ToolRun run = run_tool(excite + Words{"--quiet"});
  ASSERT_EQ(run.status, 0) << run.err;
  run = run_tool(monitor + port);
  EXPECT_EQ(run.status, 0) << run.err;
  run = run_when_calm(drive + port);
  if (ended_by_the_clock(run)) run = run_tool(drive + Words{"--emulate"});  // a machine that is too busy
  ASSERT_EQ(run.status, 0) << run.err;
  run = run_tool({"identify", "psm-3dof", "--train", folder_.path("rec.csv"), "--quiet", "--json",
                  folder_.path("id.json")});
  ASSERT_EQ(run.status, 0) << run.err;
  int found = 0;
  const json identified = json_of(folder_.path("id.json"));
  for (const json& p : identified["base_parameters"]) {
    const std::string expression = p["expression"];
    for (const auto& [name, value] :
         std::map<std::string, double>{{"coulomb_friction(yaw)", 0.15},
                                       {"coulomb_friction(pitch)", 0.15},
                                       {"coulomb_friction(insertion)", 0.8}}) {
      if (expression.rfind(name, 0) != 0) continue;
      EXPECT_NEAR(p["value"].get<double>(), value, 5.0 * p["std"].get<double>()) << expression;
      EXPECT_LT(p["std"].get<double>(), 0.2 * value) << expression;
      ++found;
    }
  }
  EXPECT_EQ(found, 3);
}

TEST_F(Dvrk, AnEmergencyStopEndsARunAndIsInTheRecording) {
  const std::string trajectory = folder_.path("traj.csv");
  std::ofstream(trajectory) << "t,q1,q2\n0,0,0\n5,0.05,0.05\n10,0.1,0.1\n15,0.05,0.1\n20,0,0\n";
  const std::string recording = folder_.path("rec.csv");
  const ToolRun run =
      run_tool(rehearse() + Words{"--event", "emergency-stop@6", "--trajectory", trajectory, "-o",
                                  recording, "--json", folder_.path("run.json")});
  EXPECT_EQ(run.status, 4) << run.err;
  EXPECT_NE(run.err.find("emergency stop"), std::string::npos) << run.err;
  const json told = json_of(folder_.path("run.json"));
  EXPECT_FALSE(told["complete"].get<bool>());
  bool listed = false;
  for (const json& fault : told["faults"]) listed = listed || fault["condition"] == 18;
  EXPECT_TRUE(listed);
  EXPECT_EQ(content_of(recording).rfind("# incomplete: no motor supply", 0), 0U);
}

TEST_F(Dvrk, UsageErrorsAreOneLine) {
  const std::string io = config();
  const struct {
    Words words;
    int status;
    const char* says;
  } cases[] = {
      {{"dvrk"}, 2, ""},
      {{"dvrk", "read", "-o", folder_.path("r.csv")}, 2, "--config or --arm"},
      {{"dvrk", "emulate", "--arm", "PSM9", "--port", "0"}, 2, "PSM9"},
      {{"dvrk", "emulate", "--config", io, "--event", "flood@3", "--port", "0"}, 2, "flood@3"},
      {{"dvrk", "emulate", "--config", io, "--event", "reboot:9@3", "--port", "0"}, 2, "board 9"},
      {{"dvrk", "emulate", "--config", io, "--event", "amp-fault:6@3", "--port", "0"},
       2,
       "amp-fault:BOARD.AXIS@S"},
      {{"dvrk", "emulate", "--config", io, "--event", "late@3", "--port", "0"},
       2,
       "late=SECONDS@S"},
      {{"dvrk", "emulate", "--config", io, "--firmware", "6", "--port", "0"}, 2, "--firmware"},
      {{"dvrk", "emulate", "--config", folder_.write("dqla.xml", with_replaced(io_xml(), "QLA1", "DQLA")),
        "--port", "0"},
       3,
       "DQLA"},
      {{"dvrk", "config", "--config",
        folder_.write("amps.xml", with_replaced(io_xml(), "Value=\"5.0\"", "Value=\"13.4\""))},
       3,
       "MaxCurrent 13.4"},
      {{"dvrk", "run", "--config", io, "--trajectory", folder_.path("none.csv"), "-o",
        folder_.path("r.csv"), "--largest-error", "0.1,0.2,0.3"},
       3,
       "none.csv"},
      {{"dvrk", "monitor", "--config", folder_.path("none.xml")}, 3, "none.xml"},
      {{"dvrk", "read", "--config", io, "--port", "9", "-o", folder_.path("r.csv")},
       3,
       "no board answers"},
      {{"dvrk", "run", "--config", io, "--trajectory", folder_.path("none.csv"), "-o",
        folder_.path("r.csv")},
       3,
       "none.csv"},
      {{"dvrk", "run", "--config", io, "-o", folder_.path("r.csv")}, 2, "--trajectory"},
      {{"dvrk", "run", "--config", io, "--controller", "gravity", "-o", folder_.path("r.csv")},
       2,
       "needs a model with values"},
      {{"dvrk", "run", "--config", io, "--controller", "gravity", "--model", "psm-3dof", "-o",
        folder_.path("r.csv")},
       3,
       "psm-3dof has 3 joints"},
      {{"dvrk", "run", "--config", io, "--controller", "gravity", "--model", "planar-2r", "--gains",
        "pid.yaml", "-o", folder_.path("r.csv")},
       2,
       "--gains"},
      {{"dvrk", "run", "--arm", "PSM1", "--controller", "gravity", "--model", "psm-3dof", "-o",
        folder_.path("r.csv")},
       3,
       "no values"},
  };
  for (const auto& one : cases) {
    const ToolRun run = run_tool(one.words);
    EXPECT_EQ(run.status, one.status) << run.err;
    EXPECT_EQ(run.error_lines(), 1) << run.err;
    EXPECT_NE(run.err.find(one.says), std::string::npos) << run.err;
  }
}

}  // namespace
}  // namespace veridyn
