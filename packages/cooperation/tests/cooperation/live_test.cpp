#include "veridyn/cooperation/live.hpp"

#include <gtest/gtest.h>

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cooperation/waiting_lines.hpp"
#include "veridyn/math/require.hpp"

// Commands by line: their effect, and that the end of the input holds the arms.

namespace veridyn {
namespace {

Scenario example(const std::string& name) {
  return read_scenario(std::string(VERIDYN_SOURCE_DIR) + "/examples/cooperate/" + name + ".yaml");
}

class Given final : public LineSource {
 public:
  explicit Given(std::deque<std::string> lines) : lines_(std::move(lines)) {}
  bool next(std::string& line) override {
    if (lines_.empty()) return false;
    line = lines_.front();
    lines_.pop_front();
    return true;
  }
  bool closed() const override { return lines_.empty(); }

 private:
  std::deque<std::string> lines_;
};

// A line source whose lines arrive at given calls. A waiting loop calls it once in a cycle, a running one twice.
class Timed final : public LineSource {
 public:
  struct Line {
    int from;
    std::string words;
  };
  explicit Timed(std::deque<Line> lines, bool script = false) : lines_(std::move(lines)), script_(script) {}
  bool next(std::string& line) override {
    if (lines_.empty() || lines_.front().from > cycle_) {
      ++cycle_;
      return false;
    }
    line = lines_.front().words;
    lines_.pop_front();
    return true;
  }
  bool closed() const override { return lines_.empty() && cycle_ > 6000; }
  bool is_script() const override { return script_; }

 private:
  std::deque<Line> lines_;
  bool script_;
  int cycle_ = 0;
};

// Displacement of the leader along x at each report [m].
struct Way {
  std::vector<double> x;
  LiveReport tell;
  std::vector<std::string> refusals;
  Way() {
    tell.state = [this](const std::string& line) { x.push_back(std::atof(line.c_str() + line.find("master=") + 7)); };
    tell.refused = [this](const std::string& line) { refusals.push_back(line); };
  }
  double at(std::size_t report) const { return x.at(report) - x.front(); }
};

LiveOptions at_once() {
  LiveOptions o;
  o.pace = 0.0;
  o.tell = 100.0;
  return o;
}

TEST(Live, MalformedCommandLinesAreRefused) {
  const Scenario s = example("two-arms-spring");
  EXPECT_TRUE(std::holds_alternative<LiveAlive>(parse_live_command("  # a remark", s)));
  EXPECT_TRUE(std::holds_alternative<LiveQuit>(parse_live_command("quit", s)));
  const auto move = std::get<ScenarioCommand>(parse_live_command("move 0.01 0 -0.02 1.5", s));
  EXPECT_EQ(move.way, Eigen::Vector3d(0.01, 0.0, -0.02));
  EXPECT_EQ(move.over, 1.5);
  EXPECT_EQ(std::get<ScenarioCommand>(parse_live_command("force spring 5 1", s)).amount, 5.0);
  for (const char* wrong : {"mov 1 2 3 4", "move 1 2 3", "move 1 2 3 0", "move 1 2 x 1",
                            "move 1 2 3 4 5", "force sprin 5 1", "wait -1", "jog 1 2 nan", "wait 1e999", "arm left 0 0 0 1", "take", "release spring now", "tighten 1", "Stop"})
    EXPECT_THROW(parse_live_command(wrong, s), InvalidInput) << wrong;
}

TEST(Live, StandardInputIsReadInBoundedLines) {
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const int own = ::dup(STDIN_FILENO);
  ::dup2(ends[0], STDIN_FILENO);
  const auto source = open_line_source("-");
  std::string line;
  EXPECT_FALSE(source->next(line));  // never blocks
  const auto write = [&](const std::string& bytes) {
    EXPECT_EQ(::write(ends[1], bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  };
  EXPECT_FALSE(source->is_script());  // somebody may speak in between
  write("stop\n\njog 0 0");
  for (const char* wanted : {"stop", ""}) {
    EXPECT_TRUE(source->next(line));
    EXPECT_EQ(line, wanted);
  }
  EXPECT_FALSE(source->next(line));  // an incomplete line is not returned
  write(" 0.1\n" + std::string(9000, 'x'));
  EXPECT_TRUE(source->next(line));
  EXPECT_EQ(line, "jog 0 0 0.1");
  EXPECT_TRUE(source->next(line)) << "a line without an end would be read for ever";
  EXPECT_THROW(parse_live_command(line, example("two-arms-spring")), InvalidInput);
  EXPECT_FALSE(source->next(line));
  write(" stop\nquit");  // the rest of a refused line is no command
  ::close(ends[1]);
  EXPECT_FALSE(source->closed());
  EXPECT_TRUE(source->next(line));
  EXPECT_EQ(line, "quit");  // also without its end
  EXPECT_FALSE(source->next(line));
  EXPECT_TRUE(source->closed());
  std::FILE* file = std::tmpfile();
  ASSERT_NE(file, nullptr);
  ::dup2(::fileno(file), STDIN_FILENO);
  EXPECT_TRUE(open_line_source("-")->is_script());
  std::fclose(file);
  ::dup2(own, STDIN_FILENO);
  ::close(own);
  ::close(ends[0]);
}

// The first 1024 bytes of a longer datagram may be a command by chance: "2" for "20" here.
TEST(Live, AnOverlongDatagramIsRejected) {
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int free_port = ::socket(AF_INET, SOCK_DGRAM, 0);
  ASSERT_EQ(::bind(free_port, reinterpret_cast<const sockaddr*>(&at), sizeof at), 0);
  socklen_t size = sizeof at;
  ASSERT_EQ(::getsockname(free_port, reinterpret_cast<sockaddr*>(&at), &size), 0);
  ::close(free_port);
  const auto source = open_line_source("udp:" + std::to_string(ntohs(at.sin_port)));
  const int hand = ::socket(AF_INET, SOCK_DGRAM, 0);
  const auto send = [&](const std::string& bytes) {
    EXPECT_EQ(::sendto(hand, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&at), sizeof at),
              static_cast<ssize_t>(bytes.size()));
  };
  const std::string move = "move 0 0 0.01";
  send(move + std::string(1024 - move.size() - 1, ' ') + "2");
  send(move + std::string(1024 - move.size() - 1, ' ') + "20");
  std::string line;
  const Scenario s = example("two-arms-spring");
  ASSERT_TRUE(source->next(line));
  EXPECT_EQ(std::get<ScenarioCommand>(parse_live_command(line, s)).over, 2.0);
  ASSERT_TRUE(source->next(line));
  EXPECT_THROW(parse_live_command(line, s), InvalidInput) << line;
  EXPECT_FALSE(source->next(line));
  ::close(hand);
}

TEST(Live, InvalidCommandsAreRefusedBeforeTheRun) {
  const Scenario s = example("two-arms-spring");
  EXPECT_THROW(open_line_source("tcp:5"), InvalidInput);
  for (double LiveOptions::*one : {&LiveOptions::pace, &LiveOptions::silence, &LiveOptions::hold, &LiveOptions::longest,
                                   &LiveOptions::tell}) {
    for (const double value : {-1.0, std::nan("")}) {
      LiveOptions wrong = at_once();
      wrong.*one = value;
      Given lines({"quit"});
      EXPECT_THROW(run_live(s, lines, wrong, {}), InvalidInput);
    }
  }
}

// The line stays open but sends nothing: a jog ends by itself, a watched line is lost.
TEST(Live, AJogEndsWithoutFurtherCommands) {
  class Silent final : public LineSource {
   public:
    bool next(std::string& line) override {
      line = "jog 0.01 0 0";
      return std::exchange(speaks_, false);
    }
    bool closed() const override { return false; }

   private:
    bool speaks_ = true;
  };
  for (const bool watched : {false, true}) {
    Silent lines;
    LiveOptions options = at_once();
    options.longest = 2.5;
    options.watches_silence = watched;
    double moved = 0.0, at_end = 0.0;
    options.tell = 0.5;
    LiveReport tell;
    std::vector<double> x;
    tell.state = [&](const std::string& line) { x.push_back(std::atof(line.c_str() + line.find("master=") + 7)); };
    const LiveRun run = run_live(example("two-arms-spring"), lines, options, tell);
    ASSERT_GE(x.size(), 4U);
    moved = x.back() - x.front();
    at_end = x.back() - x[x.size() - 2];
    EXPECT_NEAR(moved, 0.005, 0.0015);
    EXPECT_NEAR(at_end, 0.0, 2e-4);
    EXPECT_EQ(run.lost, watched);
    if (watched) {
      EXPECT_NEAR(run.lost_at, 0.5, 0.01);
    }
    EXPECT_EQ(run.report().find("the line was lost") != std::string::npos, watched) << run.report();
  }
}

TEST(Live, CommandsMoveTheObjectWithTheForceKept) {
  Given lines({"force spring 5 0.5", "wait 1", "nonsense", "move 0.01 0 0 0.5", "wait 1", "quit"});
  std::vector<std::string> told;
  LiveReport tell;
  tell.state = [&](const std::string& line) { told.push_back(line); };
  const LiveRun run = run_live(example("two-arms-spring"), lines, at_once(), tell);
  EXPECT_EQ(run.commands, 5);
  EXPECT_EQ(run.refused, 1);
  EXPECT_FALSE(run.lost);
  EXPECT_EQ(run.state, CooperativeState::kTracking);
  EXPECT_NEAR(run.time, 2.0, 0.01);
  ASSERT_GE(told.size(), 2U);
  double from = 0.0, to = 0.0, force = 0.0;
  std::sscanf(told.front().c_str() + told.front().find("master=") + 7, "%lf", &from);
  std::sscanf(told.back().c_str() + told.back().find("master=") + 7, "%lf", &to);
  std::sscanf(told.back().c_str() + told.back().find("spring=") + 7, "%lf", &force);
  EXPECT_NEAR(to - from, 0.01, 5e-4);
  EXPECT_NEAR(force, 5.0, 0.2);
}

// Infeasible commands are refused with the place, and nothing moves.
TEST(Live, InfeasibleCommandsAreRefused) {
  Given lines({"force spring 5 0.5", "wait 1", "move 5 0 0 0.1", "move 0.08 0 0 0.03", "tighten 1 0.01",
               "force spring 1000 0.1", "jog 100 0 0", "wait 0.5", "quit"});
  std::vector<std::string> refusals;
  LiveReport tell;
  tell.refused = [&](const std::string& line) { refusals.push_back(line); };
  const LiveRun run = run_live(example("two-arms-spring"), lines, at_once(), tell);
  EXPECT_EQ(run.refused, 5);
  ASSERT_EQ(refusals.size(), 5U);
  EXPECT_NE(refusals[0].find("'move 5 0 0 0.1': at "), std::string::npos) << refusals[0];
  EXPECT_LT(run.largest_force, 5.5);
  EXPECT_EQ(run.state, CooperativeState::kTracking);
}

// A wait does not delay a stop: the move ends, waiting lines before the stop are dropped, and the lines after it
// are executed. In a script a stop is executed in order.
TEST(Live, AStopIsExecutedImmediately) {
  for (const bool script : {false, true}) {
    Timed lines({{0, "move 0.05 0 0 2"}, {0, "wait 3"}, {300, "move -0.05 0 0 1"}, {500, "stop"}, {2500, "move 0 0.01 0 0.5"},
                 {4500, "quit"}}, script);
    LiveOptions options = at_once();
    options.tell = 0.1;
    options.longest = 5.0;
    Way way;
    const LiveRun run = run_live(example("two-arms-spring"), lines, options, way.tell);
    EXPECT_FALSE(run.lost);
    if (script) {
      EXPECT_NEAR(way.at(29), 0.05, 2e-3);  // nothing before the wait is over
      continue;
    }
    EXPECT_GT(way.at(5), 0.001);
    EXPECT_LT(way.at(9), 0.02);
    EXPECT_NEAR(way.at(12), way.at(9), 1e-3);  // half a second for the end of the motion
    EXPECT_NEAR(way.at(24), way.at(9), 1e-3);
    EXPECT_NEAR(run.time, 2.5, 0.01);
    EXPECT_EQ(run.commands, 5);
    EXPECT_EQ(run.refused, 1);
    ASSERT_EQ(way.refusals.size(), 1U);
    EXPECT_EQ(way.refusals[0], "stopped: 1 line before it had not been carried out and is dropped.");
  }
}

// A program writes its whole script into a pipe at once.
TEST(Live, AStopAfterOtherLinesIsExecutedInOrder) {
  Timed lines({{0, "move 0.05 0 0 2"}, {0, "wait 2.5"}, {20, "stop"}, {20, "wait 0.5"}, {20, "quit"}});
  LiveOptions options = at_once();
  options.tell = 0.1;
  Way way;
  const LiveRun run = run_live(example("two-arms-spring"), lines, options, way.tell);
  EXPECT_NEAR(way.at(24), 0.05, 2e-3);
  EXPECT_NEAR(run.time, 3.0, 0.05);
  EXPECT_EQ(run.refused, 0);
}

// A stop ends a jog that a wait keeps alive.
TEST(Live, AStopCancelsAWaitingJog) {
  Timed lines({{0, "jog 0.02 0 0"}, {0, "wait 10"}, {300, "  stop "}, {2700, "quit"}});
  LiveOptions options = at_once();
  options.tell = 0.1;
  options.longest = 3.0;
  Way way;
  const LiveRun run = run_live(example("two-arms-spring"), lines, options, way.tell);
  EXPECT_NEAR(run.time, 1.5, 0.01);
  EXPECT_LT(way.at(14), 0.02);
  EXPECT_NEAR(way.at(14), way.at(8), 5e-4);
  EXPECT_TRUE(way.refusals.empty());
}

// A source that never falls silent is not read for ever, and a stop comes through it.
TEST(Live, AStopIsExecutedDuringAFloodOfLines) {
  class Flood final : public LineSource {
   public:
    bool next(std::string& line) override {
      ++lines;
      line = lines == 1 ? "wait 100" : lines == 5000 ? "stop" : "alive";
      return true;
    }
    bool closed() const override { return false; }
    int lines = 0;
  };
  Flood flood;
  WaitingLines waiting(flood);
  std::optional<int> dropped = waiting.stopped(0.0);
  int cycles = 1;
  for (; !dropped && cycles < 100; ++cycles) dropped = waiting.stopped(0.01 * cycles);
  ASSERT_TRUE(dropped.has_value());
  EXPECT_EQ(*dropped, 4999);
  EXPECT_LE(cycles, 20);
  for (int k = 0; k < 1000; ++k) EXPECT_FALSE(waiting.stopped(1.0).has_value());
  EXPECT_EQ(flood.lines, 15000);
}

// In the middle of a move the line ends: everything stops and stays.
TEST(Live, EndOfInputEndsTheRunWithTheArmsHeld) {
  Given lines({"force spring 5 0.5", "wait 0.7", "move 0.2 0 0 2", "wait 0.5"});
  const LiveRun run = run_live(example("two-arms-spring"), lines, at_once(), {});
  EXPECT_TRUE(run.lost);
  EXPECT_NEAR(run.lost_at, 1.2, 0.01);
  EXPECT_LT(run.moved_after_loss, 1e-3);
  EXPECT_LT(run.largest_force, 7.0);
}

}  // namespace
}  // namespace veridyn
