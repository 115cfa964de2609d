#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "dvrk/board_bench.hpp"

// Sweeps the bounds of the checks that find failing motors, force sensors and encoders: each by
// factors, alone. Healthy runs with noise and 1 % of lost datagrams must not be stopped; faults must
// be found. The moments of the faults and the seeds are none of those of the drills. A cell: healthy
// runs that were stopped; faults found, and the mean time that took.

namespace veridyn::dvrk {
namespace {

constexpr double kPull = 0.35, kTension = 0.47, kCommand = 0.53;  // [s]
constexpr double kFactors[] = {0.5, 0.7, 1.0, 1.4, 2.0};
constexpr double kLost = 0.01;          // of all datagrams
constexpr double kCurrentNoise = 12.0;  // [bits]: three times that of `dvrk emulate`
constexpr double kForceNoise = 0.03;    // [N]: three times that of the examples

// Loses datagrams of both directions.
class LossyLink final : public DatagramLink {
 public:
  LossyLink(std::unique_ptr<DatagramLink> link, unsigned seed) : link_(std::move(link)), random_(seed) {}
  bool send(ByteView datagram, Destination to) noexcept override { return drops_packet() || link_->send(datagram, to); }
  Arrival receive(ByteSpan buffer, double timeout) noexcept override {
    const double until = link_->now() + timeout;
    for (;;) {
      const Arrival arrival = link_->receive(buffer, std::max(0.0, until - link_->now()));
      if (!arrival.any || !drops_packet()) return arrival;
    }
  }
  double now() noexcept override { return link_->now(); }
  void wait(double seconds) noexcept override { link_->wait(seconds); }
  std::uint32_t address_word() const noexcept override { return link_->address_word(); }
  void set_board(int board) noexcept override { link_->set_board(board); }
  void set_hub(int firmware, int board) noexcept override { link_->set_hub(firmware, board); }

 private:
  // A session is found before the network becomes bad: 1 % of a scan's requests is another matter.
  bool drops_packet() noexcept { return ++count_ > kGoodOnes && std::uniform_real_distribution<>()(random_) < kLost; }
  static constexpr long kGoodOnes = 1500;
  std::unique_ptr<DatagramLink> link_;
  std::mt19937 random_;
  long count_ = 0;
};

class LossyBoards final : public JoinedBoards {
 public:
  LossyBoards(std::unique_ptr<JoinedBoards> boards, unsigned seed) : boards_(std::move(boards)), seed_(seed) {}
  std::unique_ptr<DatagramLink> link(int arm) override {
    return std::make_unique<LossyLink>(boards_->link(arm), seed_ + static_cast<unsigned>(arm));
  }
  void run(const std::atomic<bool>& stop) override { boards_->run(stop); }
  double tension(int member) const override { return boards_->tension(member); }
  double rate(int member) const override { return boards_->rate(member); }
  double largest_force() const override { return boards_->largest_force(); }
  double true_wall_force(int wall, int channel) const override { return boards_->true_wall_force(wall, channel); }
  void attach_hand(const Hand& hand, const Eigen::Vector3d& place) override { boards_->attach_hand(hand, place); }
  void move_hand_to(const Eigen::Vector3d& place) override { boards_->move_hand_to(place); }
  Eigen::Vector3d hand_force() const override { return boards_->hand_force(); }
  void watch(std::function<void(const EmulatedInstant&)> watcher) override { boards_->watch(std::move(watcher)); }
  void activate_fault(const EmulatedFault& fault) noexcept override { boards_->activate_fault(fault); }

 private:
  std::unique_ptr<JoinedBoards> boards_;
  unsigned seed_;
};

struct Trial {
  const char* scenario;
  double pretension;    // [N]
  const char* command;  // by line; "": none
  const char* fault;    // as of --board-fault, or "sensor-drift:N/s@S"; "": healthy
};

// The bounds that are varied.
struct Bounds {
  FaultChecks checks;
  double drift_force = ScenarioControl().drift_force;
};

constexpr Trial kHealthy[] = {
    {"two-psm-spring", 3, "", ""},           {"two-psm-spring", 3, "move 0.012 0 0 0.4", ""},
    {"two-psm-spring", 2, "move 0 0.012 0 0.4", ""}, {"two-psm-spring", 1, "move 0.025 0 0 0.45", ""},
    {"two-psm-string", 2, "move 0.01 0 0 0.4", ""},  {"three-psm-springs", 2, "move 0.008 0 0 0.4", ""}};
constexpr Trial kMotors[] = {
    {"two-psm-spring", 3, "move 0.012 0 0 0.4", "stuck:master@0.58"}, {"two-psm-spring", 2, "move 0 0.012 0 0.4", "stuck:slave@0.67"},
    {"two-psm-string", 2, "move 0.01 0 0 0.4", "stuck:slave@0.57"},   {"three-psm-springs", 2, "move 0.008 0 0 0.4", "stuck:b@0.6"}};
constexpr Trial kSensors[] = {
    {"two-psm-spring", 3, "", "sensor-drift:7@0.4"},    {"two-psm-spring", 2, "", "sensor-drift:-7@0.4"},
    {"two-psm-spring", 3, "move 0.012 0 0 0.4", "sensor-drift:12@0.5"}, {"two-psm-string", 2, "", "sensor-drift:12@0.3"},
    {"two-psm-string", 3, "", "sensor-drift:-12@0.3"},  {"three-psm-springs", 2, "", "sensor-drift:7@0.4"},
    {"two-psm-spring", 3, "move 0.012 0 0 0.4", "encoder:master@0.58"}, {"two-psm-spring", 2, "move 0 0.012 0 0.4", "encoder:slave@0.67"},
    {"two-psm-spring", 3, "move 0.012 0 0 0.4", "limp:master@0.58"},    {"two-psm-spring", 2, "", "limp:slave@0.5"}};

Scenario scenario_of(const Trial& trial, unsigned seed) {
  Scenario s = board_example(trial.scenario);
  s.seed = seed;
  s.asked_largest_force = 0.0;
  ScenarioPhase pull, command;
  pull.name = "pull";
  pull.duration = kTension;
  for (std::size_t m = 0; m < s.members.size(); ++m) {
    s.members[m].sensor.noise = kForceNoise;
    ScenarioCommand c;
    c.kind = ScenarioCommand::Kind::kForce;
    c.member = static_cast<int>(m);
    c.amount = trial.pretension;
    c.over = kPull;
    pull.commands.push_back(c);
  }
  command.name = "command";
  command.duration = kCommand;
  if (*trial.command != '\0') command.commands.push_back(std::get<ScenarioCommand>(parse_live_command(trial.command, s)));
  s.phases = {pull, command};
  return s;
}

struct Outcome {
  bool stopped = false;
  double after = 0.0;  // [s] the fault
  double left = 0.0;   // [N] when power went
};

Outcome play(const Trial& trial, const Bounds& bounds, unsigned seed) {
  Scenario scenario = scenario_of(trial, seed);
  scenario.control.drift_force = bounds.drift_force;
  BoardCooperationOptions options;
  options.stepped = true;
  options.planned = options.rehearsed = false;
  options.hold = options.release = 0.3;
  options.checks = bounds.checks;
  options.current_noise = kCurrentNoise;
  options.emulate = [seed](const Scenario& s, const std::vector<CooperatingArm>& arms, const BoardCooperationOptions& how) {
    return std::make_unique<LossyBoards>(emulate_boards(s, arms, how), 100 * seed);
  };
  const std::string words = trial.fault;
  double at = 0.0;
  if (words.rfind("sensor-drift:", 0) == 0) {
    ScenarioFault fault;
    fault.kind = ScenarioFault::Kind::kSensorDrift;
    fault.member = 0;
    fault.by = std::atof(words.c_str() + words.find(':') + 1);
    at = fault.at = std::atof(words.c_str() + words.find('@') + 1);
    scenario.faults.push_back(fault);
  } else if (!words.empty()) {
    options.faults.push_back(parse_emulated_fault(words, scenario));
    at = options.faults.back().at;
  }
  std::atomic<bool> stop{false};
  const BoardCooperationRun done = run_on_boards(scenario, patient_side(scenario.arms.size()), options, stop);
  if (std::getenv("VERIDYN_SHOW") != nullptr && done.end == BoardEnd::kFault)
    std::fprintf(stderr, "%s | %s | %s : %.3f %s\n", trial.scenario, trial.command, trial.fault, done.fault_at, done.why.c_str());
  return {done.end == BoardEnd::kFault, done.fault_at - at, done.force_at_off};
}

struct Varied {
  const char* name;
  void (*scale)(Bounds&, double);
  bool of_motors;
};

const Varied kVaried[] = {
    {"follow.margin", [](Bounds& b, double f) { b.checks.follow.margin *= f; }, true},
    {"follow.share", [](Bounds& b, double f) { b.checks.follow.share *= f; }, true},
    {"follow.cycles", [](Bounds& b, double f) { b.checks.follow.cycles = static_cast<int>(std::lround(f * b.checks.follow.cycles)); }, true},
    {"drift_force", [](Bounds& b, double f) { b.drift_force *= f; }, false},
    {"drift_length", [](Bounds& b, double f) { b.checks.drift_length *= f; }, false},
    {"drift_way", [](Bounds& b, double f) { b.checks.drift_way *= f; }, false},
    {"drift_factor less one", [](Bounds& b, double f) { b.checks.drift_factor = 1.0 + f * (b.checks.drift_factor - 1.0); }, false},
    {"force_disagreement", [](Bounds& b, double f) { b.checks.force_disagreement *= f; }, false},
    {"disagreement_seconds", [](Bounds& b, double f) { b.checks.disagreement_seconds *= f; }, false}};

template <std::size_t kCount>
void report_faults(const Trial (&trials)[kCount], const Bounds& bounds, unsigned seed, double& most) {
  int found = 0;
  double mean = 0.0;
  for (const Trial& trial : trials) {
    const Outcome one = play(trial, bounds, seed);
    if (!one.stopped || one.after < 0.0) continue;
    ++found;
    mean += one.after;
    most = std::max(most, one.left);
  }
  std::printf(" %d/%zu in %.0f ms |", found, kCount, found > 0 ? 1e3 * mean / found : 0.0);
}

void sweep(unsigned seed) {
  std::printf("| bound times |");
  for (const double factor : kFactors) std::printf(" %g |", factor);
  std::printf(" left, most [N] |\n|---|---|---|---|---|---|---|\n");
  for (const Varied& varied : kVaried) {
    std::printf("| `%s` |", varied.name);
    double most = 0.0;
    for (const double factor : kFactors) {
      Bounds bounds;
      varied.scale(bounds, factor);
      int stopped = 0;
      for (const Trial& trial : kHealthy) stopped += play(trial, bounds, seed).stopped ? 1 : 0;
      std::printf(" %d/%zu;", stopped, std::size(kHealthy));
      varied.of_motors ? report_faults(kMotors, bounds, seed + 1, most) : report_faults(kSensors, bounds, seed + 1, most);
      std::fflush(stdout);
    }
    std::printf(" %.1f |\n", most);
  }
}

}  // namespace
}  // namespace veridyn::dvrk

int main(int argc, char** argv) {
  veridyn::dvrk::sweep(argc > 1 ? static_cast<unsigned>(std::atoi(argv[1])) : 71U);
}
