#include <gtest/gtest.h>

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>
#include <thread>

#include "cli/tool.hpp"

// Numbers that no sensor delivers, and a machine that ends the work: outputs are whole or absent,
// nothing is left beside them, and the status is that of docs/contract.md.

namespace veridyn {
namespace {

// A recording of planar-2r whose cells are written by a function of row, column and value.
using Cell = std::function<std::string(int row, int column, double value)>;

std::string plain(double value) {
  char out[32];
  std::snprintf(out, sizeof out, "%.9g", value);
  return out;
}

std::string rows(const Cell& cell, char separator = ',', const std::string& end = "\n") {
  std::istringstream good(planar_recording(4.0));
  std::string line;
  std::getline(good, line);
  std::replace(line.begin(), line.end(), ',', separator);
  std::string out = line + end;
  for (int row = 0; std::getline(good, line); ++row) {
    std::istringstream fields(line);
    std::string field;
    for (int column = 0; std::getline(fields, field, ','); ++column)
      out += (column == 0 ? "" : std::string(1, separator)) + cell(row, column, std::stod(field));
    out += end;
  }
  return out;
}

struct NumberCase {
  const char* name;
  std::string content;
  int status;
  const char* word;  // of the message
};

std::string with_column(int wanted, const std::function<std::string(int, double)>& write) {
  return rows([&](int row, int column, double value) {
    return column == wanted ? write(row, value) : plain(value);
  });
}

std::string with_decimal_commas(char separator) {
  return rows(
      [](int, int, double value) {
        std::string out = plain(value);
        std::replace(out.begin(), out.end(), '.', ',');
        return out;
      },
      separator);
}

std::vector<NumberCase> number_cases() {
  const auto at_50 = [](const char* word) {
    return with_column(5, [word](int row, double value) { return row == 50 ? word : plain(value); });
  };
  const Cell same = [](int, int, double value) { return plain(value); };
  return {
      {"carriage returns and line feeds", rows(same, ',', "\r\n"), 0, ""},
      {"a byte order mark", "\xEF\xBB\xBF" + rows(same), 0, ""},
      {"decimal commas between semicolons", with_decimal_commas(';'), 0, ""},
      {"decimal commas between tabs", with_decimal_commas('\t'), 0, ""},
      {"decimal commas between commas", with_decimal_commas(','), 3, "fields, expected 7"},
      {"UTF-16", "\xFF\xFE" + rows(same), 3, "UTF-16"},
      {"one torque of 1e305", at_50("1e305"), 0, "filled in from the rows beside"},
      {"one torque beyond all numbers", at_50("1e999"), 0, "1 number beyond"},
      {"one infinite torque", at_50("-inf"), 0, "1 number beyond"},
      {"torques of 1e305", with_column(5, [](int, double) { return "-1e305"; }), 3, "no usable rows"},
      {"denormal torques of a joint", with_column(5, [](int, double) { return "5e-324"; }), 4, "is zero throughout"},
      {"a joint without torque", with_column(5, [](int, double) { return "0"; }), 4, "the other joints alone do not determine the arm"},
      {"no torque anywhere",
       rows([](int, int column, double v) { return column > 4 ? std::string("0") : plain(v); }), 4,
       "torques of all joints are zero"},
      {"denormal times", with_column(0, [](int row, double) { return plain(row * 5e-324); }), 3, "sampling period"},
      {"times of 1e305", with_column(0, [](int row, double) { return plain(row * 1e305); }), 3, "sampling period"},
      {"times that run back", with_column(0, [](int, double v) { return plain(-v); }), 3, "runs back"},
      {"3 rows", rows(same).substr(0, rows(same).find("0.03,")), 4, "no usable samples"},
  };
}

TEST(Numbers, BeyondSensorRangesAreReadOrRefusedWithAReason) {
  for (const NumberCase& given : number_cases()) {
    const TemporaryFolder folder;
    const std::string recording = folder.write("recording.csv", given.content);
    const ToolRun run = run_tool({"identify", "planar-2r", "--train", recording, "--json", folder.path("o.json"),
                                  "--model-out", folder.path("m.yaml"), "--quiet"});
    EXPECT_EQ(run.status, given.status) << given.name << ": " << run.err;
    EXPECT_NE(run.err.find(given.word), std::string::npos) << given.name << ": " << run.err;
    const Words expected = given.status == 0 ? Words{"m.yaml", "o.json", "recording.csv"} : Words{"recording.csv"};
    EXPECT_EQ(folder.files(), expected) << given.name;
    if (given.status != 0) continue;
    const nlohmann::json result = json_of(folder.path("o.json"));  // a number that is none is no JSON
    for (const nlohmann::json& base : result["base_parameters"]) EXPECT_TRUE(base["value"].is_number()) << given.name;
  }
}

// Starts the tool without waiting for it.
pid_t start(const Words& words) {
  const pid_t child = ::fork();
  if (child != 0) return child;
  const int nothing = ::open("/dev/null", O_RDWR);
  for (const int stream : {0, 1, 2}) ::dup2(nothing, stream);
  std::vector<char*> argv{const_cast<char*>("veridyn")};
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  ::execv(VERIDYN_TOOL, argv.data());
  ::_exit(127);
}

TEST(AKilledTool, LeavesCompleteFilesOrNone) {
  using Clock = std::chrono::steady_clock;
  const TemporaryFolder folder;
  const Words names = {"a.urdf", "b.xml", "c.sdf", "d.h", "e.yaml", "f.json"};
  const auto words = [&](const TemporaryFolder& into) {
    return Words{"export", "planar-2r", "--urdf", into.path("a.urdf"), "--mjcf", into.path("b.xml"), "--sdf",
                 into.path("c.sdf"), "--cpp", into.path("d.h"), "--yaml", into.path("e.yaml"), "--json",
                 into.path("f.json"), "--quiet"};
  };
  const TemporaryFolder reference;
  const auto begin = Clock::now();
  ASSERT_EQ(run_tool(words(reference)).status, 0);
  const auto whole = std::chrono::duration<double>(Clock::now() - begin).count();
  std::mt19937 random(200);
  std::uniform_real_distribution<double> moment(0.0, 1.2 * whole);
  int killed = 0;
  for (int k = 0; k < 200; ++k) {
    const TemporaryFolder into;
    const pid_t child = start(words(into));
    ASSERT_GT(child, 0);
    std::this_thread::sleep_for(std::chrono::duration<double>(moment(random)));
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    if (WIFSIGNALED(status)) ++killed;
    for (const std::string& name : into.files()) {
      EXPECT_NE(std::find(names.begin(), names.end(), name), names.end()) << "left behind: " << name;
      EXPECT_EQ(content_of(into.path(name)).size(), content_of(reference.path(name)).size()) << name;
    }
  }
  EXPECT_GT(killed, 0);
}

// Ctrl-C ends a watch that still learns from a long recording at once, and writes nothing; progress is told.
TEST(AnInterruptedTool, EndsAWatchDuringItsQuietTime) {
  const TemporaryFolder folder;
  const std::string model = folder.path("model.yaml"), out = folder.path("o.json");
  ASSERT_EQ(run_tool({"export", "planar-2r", "--yaml", model, "--quiet"}).status, 0);
  const std::string recording = folder.write("recording.csv", planar_recording(12.0));
  const Words watch = {"watch", model, recording, "--json", out};
  const ToolRun whole = run_tool(watch + Words{"--learn-from", recording});
  EXPECT_EQ(whole.status, 0) << whole.err;
  for (const char* stage : {"veridyn: learning: ", "veridyn: watching: "}) EXPECT_NE(whole.err.find(stage), std::string::npos) << whole.err;
  std::filesystem::remove(out);
  const pid_t child = start(watch + Words{"--learn-from", folder.write("long.csv", planar_recording(3000.0))});
  ASSERT_GT(child, 0);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  ::kill(child, SIGINT);
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGINT) << status;
  EXPECT_FALSE(std::filesystem::exists(out));
}

// A limit on the size of files stands in for a full disk.
ToolRun run_on_full_disk(const Words& words) {
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{1024, before.rlim_max};
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  // What a build that counts its lines writes at its end could not be written either.
  const char* counts = std::getenv("LLVM_PROFILE_FILE");
  const std::string kept = counts == nullptr ? "" : counts;
  if (counts != nullptr) ::setenv("LLVM_PROFILE_FILE", "/dev/null", 1);
  ::setrlimit(RLIMIT_FSIZE, &small);
  const ToolRun run = run_tool(words);
  ::setrlimit(RLIMIT_FSIZE, &before);
  if (counts != nullptr) ::setenv("LLVM_PROFILE_FILE", kept.c_str(), 1);
  std::signal(SIGXFSZ, handler);
  return run;
}

TEST(AFullDisk, IsReportedAndLeavesNoFile) {
  const TemporaryFolder inputs;
  const std::string recording = inputs.write("recording.csv", planar_recording(4.0));
  for (const Words& words : {Words{"identify", "planar-2r", "--train", recording, "--json"},
                             Words{"identify", "planar-2r", "--train", recording, "--model-out"},
                             Words{"identify", "planar-2r", "--train", recording, "--factor-out"},
                             Words{"identify", "planar-2r", "--train", recording, "--report"},
                             Words{"check", recording, "--json"},
                             Words{"export", "planar-2r", "--cpp"},
                             Words{"simulate", "planar-2r", "--trajectory", recording, "-o"}}) {
    const TemporaryFolder folder;
    const ToolRun run = run_on_full_disk(words + Words{folder.path("out"), "--quiet"});
    EXPECT_EQ(run.status, 3) << words[0] << " " << words.back() << ": " << run.err;
    EXPECT_EQ(run.error_lines(), 1) << run.err;
    EXPECT_NE(run.err.find("disk full"), std::string::npos) << run.err;
    EXPECT_EQ(folder.files(), Words{}) << words[0] << " " << words.back();
  }
}

// A pipe is opened once: opened and closed before the work, it would have ended for its reader.
TEST(APipeAsOutput, ReceivesTheCompleteResult) {
  const TemporaryFolder folder;
  const std::string recording = folder.write("recording.csv", planar_recording(4.0));
  const std::string pipe = folder.path("pipe"), got = folder.path("got.json");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  std::thread reader([&] {
    std::ifstream in(pipe, std::ios::binary);
    std::ofstream(got, std::ios::binary) << in.rdbuf();
  });
  const ToolRun run = run_tool({"identify", "planar-2r", "--train", recording, "--json", pipe, "--quiet"}, "", 60);
  if (run.status != 0) std::ofstream(pipe).close();  // which ends the reader
  reader.join();
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(json_of(got)["command"], "identify");
}

// A log on a full disk, a program that closed its streams: the work is done, and no file takes a stream's place.
TEST(AFullOrClosedErrorStream, DoesNotChangeTheExitStatus) {
  if (!std::ofstream("/dev/full").is_open()) GTEST_SKIP() << "no /dev/full here";
  const TemporaryFolder folder;
  const std::string recording = folder.write("recording.csv", planar_recording(4.0));
  const std::string out = folder.path("o.json");
  const std::string command = std::string(VERIDYN_TOOL) + " identify planar-2r --train '" + recording + "' --json '" + out + "'";
  const auto status_of = [](const std::string& line) {
    const int status = std::system(line.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  };
  for (const char* streams : {" > /dev/null 2> /dev/full", " > /dev/null 2>&-", " < /dev/null > /dev/null 2>&- <&-"}) {
    EXPECT_EQ(status_of(command + streams), 0) << streams;
    EXPECT_EQ(json_of(out)["command"], "identify") << streams;
    std::filesystem::remove(out);
  }
  EXPECT_EQ(status_of(std::string(VERIDYN_TOOL) + " info nobody 2> /dev/full"), 3);
  EXPECT_EQ(status_of(command + " >&- 2> /dev/null"), 3);
  EXPECT_EQ(json_of(out)["command"], "identify");
}

// What a file says cannot drive the terminal that shows the error.
TEST(AnErrorLine, HoldsNoControlCharacters) {
  const TemporaryFolder folder;
  const std::string robot = folder.write("robot.yaml", "veridyn: 1\nname: a\n\"evil\\e[2J\\nline\": 1\n");
  const ToolRun run = run_tool({"info", robot});
  EXPECT_EQ(run.status, 3);
  EXPECT_EQ(run.error_lines(), 1) << run.err;
  EXPECT_EQ(run.err.find('\x1b'), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("evil?[2J?line"), std::string::npos) << run.err;
}

}  // namespace
}  // namespace veridyn
