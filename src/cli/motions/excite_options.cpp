#include "cli/motions/excite_options.hpp"

#include <CLI/CLI.hpp>
#include <cstdlib>

#include "files/words.hpp"
#include "veridyn/tool/choice.hpp"
#include "veridyn/tool/common_options.hpp"

namespace veridyn::cli {
namespace {

[[noreturn]] void fail(const std::string& option, const std::string& words,
                       const std::string& expected) {
  throw CLI::ValidationError(option, "found '" + words + "', expected " + expected);
}

// Parses numbers separated by commas; `counts` are the allowed numbers of them.
std::vector<double> numbers(const std::string& option, const std::string& words,
                            const std::string& list, const std::vector<size_t>& counts,
                            const std::string& expected) {
  std::vector<double> out;
  for (const std::string& word : CLI::detail::split(list, ',')) {
    const std::optional<double> value = number_in(word);
    if (!value || std::isnan(*value)) fail(option, words, expected);
    out.push_back(*value);
  }
  for (const size_t count : counts) {
    if (out.size() == count) return out;
  }
  fail(option, words, expected);
}

struct Named {
  std::string frame;
  std::vector<double> numbers;
};

Named parse_named_numbers(const std::string& option, const std::string& words, const std::vector<size_t>& counts,
            const std::string& expected) {
  const auto colon = words.find(':');
  if (colon == 0 || colon == std::string::npos) fail(option, words, expected);
  return {words.substr(0, colon),
          numbers(option, words, words.substr(colon + 1), counts, expected)};
}

}  // namespace

std::pair<Cause, Cause> parse_rivals(const Model& arm, const std::string& words) {
  const std::vector<std::string> two = CLI::detail::split(words, ',');
  if (two.size() != 2 || two[0].empty() || two[1].empty()) {
    fail("--between", words, "two causes EFFECT:PLACE,EFFECT:PLACE, as payload:tool,torque_gain:2");
  }
  return {parse_cause(arm, two[0]), parse_cause(arm, two[1])};
}

FrameBox parse_frame_box(const std::string& words) {
  const Named n = parse_named_numbers("--box", words, {6}, "FRAME:X,X,Y,Y,Z,Z from and to, in m; inf is open");
  return {n.frame,
          {n.numbers[0], n.numbers[2], n.numbers[4]},
          {n.numbers[1], n.numbers[3], n.numbers[5]}};
}

Obstacle parse_obstacle_box(const std::string& words) {
  const std::string expected = "X,X,Y,Y,Z,Z from and to, in m; inf is open";
  const std::vector<double> v = numbers("--keep-out", words, words, {6}, expected);
  if (!(v[0] < v[1] && v[2] < v[3] && v[4] < v[5])) fail("--keep-out", words, expected);
  return {"box " + words, {v[0], v[2], v[4]}, {v[1], v[3], v[5]}};
}

Sphere parse_sphere(const std::string& words) {
  const Named n = parse_named_numbers("--sphere", words, {1, 4}, "FRAME:R or FRAME:R,X,Y,Z in m");
  if (!(n.numbers[0] > 0.0)) fail("--sphere", words, "a positive radius");
  Sphere out{n.frame, n.numbers[0]};
  if (n.numbers.size() == 4) out.centre = {n.numbers[1], n.numbers[2], n.numbers[3]};
  return out;
}

Sphere parse_obstacle(const std::string& words) {
  const std::string expected = "X,Y,Z,R in m, with a positive radius";
  const std::vector<double> v = numbers("--obstacle", words, words, {4}, expected);
  if (!(v[3] > 0.0)) fail("--obstacle", words, expected);
  return {"world", v[3], {v[0], v[1], v[2]}};
}

InsertionRange parse_insertion_range(const std::string& words) {
  const Named n = parse_named_numbers("--insertion", words, {2, 5},
                        "FRAME:LOW,HIGH or FRAME:LOW,HIGH,X,Y,Z (the remote centre) in m");
  InsertionRange out{n.frame, {0, 0, 0}, n.numbers[0], n.numbers[1]};
  if (n.numbers.size() == 5) out.centre = {n.numbers[2], n.numbers[3], n.numbers[4]};
  return out;
}

std::vector<SpherePair> sphere_pairs(const std::vector<Sphere>& spheres,
                                     const std::vector<Sphere>& obstacles, double clearance) {
  std::vector<SpherePair> out;
  for (size_t a = 0; a < spheres.size(); ++a) {
    for (size_t b = a + 1; b < spheres.size(); ++b) {
      if (spheres[a].frame != spheres[b].frame) out.push_back({spheres[a], spheres[b], clearance});
    }
    for (const Sphere& fixed : obstacles) out.push_back({spheres[a], fixed, clearance});
  }
  return out;
}

void add_motion_options(CLI::App& command, ExcitationOptions& o) {
  const char* const group = "Motion";
  const auto number = [&](const char* option, double& target, const char* unit, const char* help) {
    command.add_option(option, target, help)
        ->option_text(unit)
        ->check(CLI::PositiveNumber)
        ->capture_default_str()
        ->group(group);
  };
  number("--frequency", o.frequency, "HZ", "Base frequency of the Fourier series [Hz] (0.13)");
  add_value(command, "--harmonics N", o.harmonics, "Harmonics per joint (5)", CLI::Range(2, 100))
      ->group(group);
  number("--duration", o.duration, "S",
         "Duration [s]; rounded to whole periods, at least two (30)");
  add_value(
      command, "--slow-passes N", o.slow_passes,
      "Constant-velocity segments of every joint at the end, at 1 to 10 % of its speed limit (0)",
      CLI::Range(0, 100))
      ->group(group);
  number("--rate", o.rate, "HZ", "Sample rate [Hz] (200)");
  add_value(command, "--speed X", o.speed, "Play the same path at this share of its designed speed, for a first run (1)",
            CLI::Range(0.01, 1.0))
      ->group(group);
  add_value(command, "--limit-share X", o.limit_share,
            "Share of each limit to use (default: the margin of the safety supervisor, 0.98 of "
            "speed, 0.95 of torque, and the range as far as the arm can stop before its end)",
            CLI::Range(0.01, 1.0))
      ->group(group);
}

void add_search_options(CLI::App& command, ExcitationOptions& o) {
  const char* const group = "Search";
  add_choice(command, "--criterion", o.criterion,
             {ExcitationCriterion::kDOptimal, ExcitationCriterion::kCondition,
              ExcitationCriterion::kAOptimal, ExcitationCriterion::kDiscriminate},
             "Smallest condition number, confidence ellipsoid or mean relative deviation, or two "
             "causes told apart")
      ->group(group);
  add_friction_option(command, o.friction);
  add_choice(command, "--columns-scaled", o.scaling,
             {ColumnScaling::kNorm, ColumnScaling::kNone, ColumnScaling::kOrthogonal},
             "Scaling of the regressor's columns before its condition number")
      ->group(group);
  add_value(command, "--essential SHARE", o.essential,
            "Regroup base parameters that contribute less than this share (0: keep all)",
            CLI::Range(0.0, 0.99))
      ->group(group);
  add_choice(command, "--solver", o.solver,
             {ExcitationSolver::kInteriorPoint, ExcitationSolver::kIpopt, ExcitationSolver::kNlopt,
              ExcitationSolver::kRandom},
             "Optimiser")
      ->group(group);
  add_value(command, "--starts N", o.starts, "Number of independent starts (2)",
            CLI::Range(1, 100000))
      ->group(group);
  add_value(command, "--iterations,--evaluations N", o.iterations,
            "Iteration limit of each start (400)", CLI::Range(1, 100000000))
      ->group(group);
  add_value(command, "--seed N", o.seed, "Random seed (1)")->group(group);
}

}  // namespace veridyn::cli
