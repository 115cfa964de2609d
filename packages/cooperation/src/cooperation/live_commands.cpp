#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <sstream>
#include <utility>

#include "veridyn/files/words.hpp"
#include "veridyn/model/excerpt.hpp"
#include "veridyn/dvrk/protocol/udp_port.hpp"
#include "veridyn/model/suggestion.hpp"
#include "veridyn/cooperation/live.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

// The words of a line, in order; a missing or malformed one throws InvalidInput with `what` was expected.
class Words {
 public:
  explicit Words(const std::string& line) : in_(line) {}

  bool word(std::string& out) { return static_cast<bool>(in_ >> out); }
  std::string name(const char* what) {
    std::string out;
    require(word(out), "found the end of the line, expected ", what, ".");
    return out;
  }
  double number(const char* what) {
    const std::string one = name(what);
    const std::optional<double> x = number_in(one);
    require(x && std::isfinite(*x), "found '", excerpt(one), "', expected ", what, ".");
    return *x;
  }
  double seconds() {
    const double x = number("seconds");
    require(x > 0.0, "found ", x, " s, expected a time above zero.");
    return x;
  }
  Eigen::Vector3d vector() {
    Eigen::Vector3d out;
    for (double& x : out) x = number("three numbers");
    return out;
  }
  void end() {
    std::string rest;
    require(!word(rest), "found '", excerpt(rest), "', expected the end of the line.");
  }

 private:
  std::istringstream in_;
};

// Index of the arm or member with that name; throws InvalidInput with the known names.
template <typename Things>
int index_of(const std::string& name, const Things& things, const char* what) {
  std::vector<std::string> names;
  for (const auto& thing : things) {
    if (thing.name == name) return static_cast<int>(names.size());
    names.push_back(thing.name);
  }
  throw InvalidInput(text("found no ", what, " '", name, "'", did_you_mean(name, names),
                          ", expected one of: ", listed(names), "."));
}

ScenarioCommand empty_command(ScenarioCommand::Kind kind) {
  ScenarioCommand out;
  out.kind = kind;
  return out;
}

constexpr std::size_t kLongestLine = 1024;

// The beginning of a line that is too long, followed by dots, so that it is no command.
std::string shortened_line(const std::string& line) { return line.substr(0, 40) + " ..."; }

class StandardInput final : public LineSource {
 public:
  bool next(std::string& line) override {
    for (;;) {
      const auto end = held_.find('\n');
      if (end != std::string::npos) {
        line = held_.substr(0, end);
        held_.erase(0, end + 1);
        if (!std::exchange(skips_, false)) return true;
        continue;
      }
      if (held_.size() > kLongestLine) {  // not a command: its first bytes are reported, and the rest is skipped
        line = shortened_line(held_);
        held_.clear();
        if (!std::exchange(skips_, true)) return true;
      }
      if (closed_) return false;
      pollfd at{STDIN_FILENO, POLLIN, 0};
      if (::poll(&at, 1, 0) <= 0) return false;
      char bytes[512];
      const ssize_t got = ::read(STDIN_FILENO, bytes, sizeof(bytes));
      if (got <= 0) {
        closed_ = true;
        if (!held_.empty()) held_ += '\n';
        continue;
      }
      held_.append(bytes, static_cast<std::size_t>(got));
    }
  }
  bool closed() const override { return closed_ && held_.empty(); }
  bool is_script() const override {
    struct stat at {};
    return ::fstat(STDIN_FILENO, &at) == 0 && S_ISREG(at.st_mode);
  }

 private:
  std::string held_;
  bool closed_ = false;
  bool skips_ = false;  // skips the rest of a line that was refused
};

// Lines from the first sender only, until the run ends, which its silence causes.
class UdpLines final : public LineSource {
 public:
  explicit UdpLines(const std::string& place)
      : port_(place, std::numeric_limits<double>::infinity(), "live commands") {}

  bool next(std::string& line) override {
    char bytes[kLongestLine + 1];
    UdpPort::Datagram got;
    if (!port_.receive(bytes, sizeof(bytes), got)) return false;
    line.assign(bytes, got.size);
    if (line.size() > kLongestLine) line = shortened_line(line);
    while (!line.empty() && (line.back() == '\n' || line.back() == '\r')) line.pop_back();
    return true;
  }
  bool closed() const override { return false; }

 private:
  UdpPort port_;
};

}  // namespace

LiveCommand parse_live_command(const std::string& line, const Scenario& scenario) {
  using Kind = ScenarioCommand::Kind;
  static const std::vector<std::string> known = {"move", "turn",    "jog",  "force", "tighten", "arm",
                                                 "release", "take", "stop", "alive", "wait",    "quit"};
  Words words(line);
  std::string what;
  if (!words.word(what) || what[0] == '#') return LiveAlive{};
  LiveCommand out = LiveAlive{};
  if (what == "move" || what == "turn") {
    ScenarioCommand c = empty_command(what == "move" ? Kind::kMove : Kind::kTurn);
    c.way = words.vector();
    c.over = words.seconds();
    out = c;
  } else if (what == "jog") {
    out = LiveJog{words.vector()};
  } else if (what == "force") {
    ScenarioCommand c = empty_command(Kind::kForce);
    c.member = index_of(words.name("a member"), scenario.members, "member");
    c.amount = words.number("newtons");
    c.over = words.seconds();
    out = c;
  } else if (what == "tighten") {
    ScenarioCommand c = empty_command(Kind::kTighten);
    c.amount = words.number("metres");
    c.over = words.seconds();
    out = c;
  } else if (what == "arm") {
    ScenarioCommand c = empty_command(Kind::kMoveArm);
    c.arm = index_of(words.name("an arm"), scenario.arms, "arm");
    c.way = words.vector();
    c.over = words.seconds();
    out = c;
  } else if (what == "release" || what == "take") {
    ScenarioCommand c = empty_command(what == "take" ? Kind::kTake : Kind::kRelease);
    c.member = index_of(words.name("a member"), scenario.members, "member");
    out = c;
  } else if (what == "stop") {
    out = LiveStop{};
  } else if (what == "wait") {
    out = LiveWait{words.seconds()};
  } else if (what == "quit") {
    out = LiveQuit{};
  } else {
    require(what == "alive", "found '", excerpt(what), "'", did_you_mean(what, known), ", expected one of: ",
            listed(known), ".");
  }
  words.end();
  return out;
}

std::unique_ptr<LineSource> open_line_source(const std::string& name) {
  if (name == "-") return std::make_unique<StandardInput>();
  require(name.rfind("udp:", 0) == 0, "found the line '", name,
          "', expected - or udp:[ADDRESS:]PORT.");
  return std::make_unique<UdpLines>(name.substr(4));
}

}  // namespace veridyn
