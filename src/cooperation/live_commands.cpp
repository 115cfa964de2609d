#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <sstream>

#include "model/suggestion.hpp"
#include "veridyn/cooperation/live.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

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
    char* end = nullptr;
    const double x = std::strtod(one.c_str(), &end);
    require(*end == '\0' && std::isfinite(x), "found '", one, "', expected ", what, ".");
    return x;
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
    require(!word(rest), "found '", rest, "', expected the end of the line.");
  }

 private:
  std::istringstream in_;
};

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

ScenarioCommand command(ScenarioCommand::Kind kind) {
  ScenarioCommand out;
  out.kind = kind;
  return out;
}

class StandardInput final : public LineSource {
 public:
  bool next(std::string& line) override {
    for (;;) {
      const auto end = held_.find('\n');
      if (end != std::string::npos) {
        line = held_.substr(0, end);
        held_.erase(0, end + 1);
        return true;
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

 private:
  std::string held_;
  bool closed_ = false;
};

class UdpLines final : public LineSource {
 public:
  UdpLines(const std::string& address, int port) {
    socket_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK, 0);
    require(socket_ >= 0, "live commands: found no socket: ", std::strerror(errno), ".");
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_port = htons(static_cast<std::uint16_t>(port));
    const bool known = ::inet_pton(AF_INET, address.c_str(), &at.sin_addr) == 1;
    if (known && ::bind(socket_, reinterpret_cast<const sockaddr*>(&at), sizeof(at)) == 0) return;
    const std::string why = known ? std::strerror(errno) : "no IPv4 address";
    ::close(socket_);
    throw InvalidInput(text("live commands: UDP ", address, ":", port, ": ", why, "."));
  }
  ~UdpLines() override { ::close(socket_); }
  UdpLines(const UdpLines&) = delete;
  UdpLines& operator=(const UdpLines&) = delete;

  bool next(std::string& line) override {
    char bytes[1024];
    const ssize_t got = ::recv(socket_, bytes, sizeof(bytes), 0);
    if (got < 0) return false;
    line.assign(bytes, static_cast<std::size_t>(got));
    while (!line.empty() && (line.back() == '\n' || line.back() == '\r')) line.pop_back();
    return true;
  }
  bool closed() const override { return false; }

 private:
  int socket_ = -1;
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
    ScenarioCommand c = command(what == "move" ? Kind::kMove : Kind::kTurn);
    c.way = words.vector();
    c.over = words.seconds();
    out = c;
  } else if (what == "jog") {
    out = LiveJog{words.vector()};
  } else if (what == "force") {
    ScenarioCommand c = command(Kind::kForce);
    c.member = index_of(words.name("a member"), scenario.members, "member");
    c.amount = words.number("newtons");
    c.over = words.seconds();
    out = c;
  } else if (what == "tighten") {
    ScenarioCommand c = command(Kind::kTighten);
    c.amount = words.number("metres");
    c.over = words.seconds();
    out = c;
  } else if (what == "arm") {
    ScenarioCommand c = command(Kind::kMoveArm);
    c.arm = index_of(words.name("an arm"), scenario.arms, "arm");
    c.way = words.vector();
    c.over = words.seconds();
    out = c;
  } else if (what == "release" || what == "take") {
    ScenarioCommand c = command(what == "take" ? Kind::kTake : Kind::kRelease);
    c.member = index_of(words.name("a member"), scenario.members, "member");
    out = c;
  } else if (what == "stop") {
    out = LiveStop{};
  } else if (what == "wait") {
    out = LiveWait{words.seconds()};
  } else if (what == "quit") {
    out = LiveQuit{};
  } else {
    require(what == "alive", "found '", what, "'", did_you_mean(what, known), ", expected one of: ",
            listed(known), ".");
  }
  words.end();
  return out;
}

std::unique_ptr<LineSource> open_line_source(const std::string& name) {
  if (name == "-") return std::make_unique<StandardInput>();
  const auto last = name.rfind(':');
  char* end = nullptr;
  const long port = last == std::string::npos ? 0 : std::strtol(name.c_str() + last + 1, &end, 10);
  require(name.rfind("udp:", 0) == 0 && end != nullptr && *end == '\0' && port > 0 && port < 65536,
          "found the line '", name, "', expected - or udp:[ADDRESS:]PORT.");
  const std::string address = last > 4 ? name.substr(4, last - 4) : "127.0.0.1";
  return std::make_unique<UdpLines>(address, static_cast<int>(port));
}

}  // namespace veridyn
