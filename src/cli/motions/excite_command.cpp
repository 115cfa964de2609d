#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "veridyn/tool/common_options.hpp"
#include "cli/motions/excite_options.hpp"
#include "excitation/cautions.hpp"
#include "veridyn/tool/kept_results.hpp"
#include "veridyn/tool/messages.hpp"
#include "veridyn/tool/open_commands.hpp"
#include "veridyn/tool/option_checks.hpp"
#include "tool/recording_options.hpp"
#include "veridyn/tool/sound_arguments.hpp"
#include "veridyn/excitation/excitation.hpp"
#include "veridyn/identification/identification.hpp"
#include "recordings/recorded_motion.hpp"
#include "veridyn/recordings/recording.hpp"
#include "files/file_hash.hpp"
#include "math/numbers.hpp"
#include "files/output_file.hpp"
#include "files/robot_format.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/model/fixed_coordinates.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/report/pages.hpp"
#include "veridyn/report/motion_json.hpp"
#include "veridyn/simulation/plausible_model.hpp"

namespace veridyn::cli {
namespace {

struct ExciteRequest {
  const CLI::App* command = nullptr;  // the command whose options were given
  std::string robot;
  std::string output;
  std::string coefficients, resume;
  std::string model;
  std::vector<std::string> given, noise_of;
  PreprocessingOptions reading;  // options for reading the recordings of --given and --noise-of
  std::vector<std::string> boxes, spheres, obstacles, insertions;
  std::string between;
  std::optional<double> clearance;  // [m]; nullopt: 0 between spheres, kLinkClearance between links
  std::string collisions = "auto", shapes;
  std::vector<std::string> keep_out;
  std::optional<double> link_radius, floor;
  std::optional<double> torque_noise;
  std::optional<ExciteExtension> extension;
  ExcitationOptions options;
  CommonOptions common;
};

// Ctrl-C ends the search with the best motion so far; a second one ends the program.
volatile std::sig_atomic_t interrupted = 0;

class Interruptible {
 public:
  Interruptible() {
    interrupted = 0;
    struct sigaction action {};
    action.sa_handler = [](int) { interrupted = 1; };
    action.sa_flags = static_cast<int>(SA_RESETHAND);
    ::sigaction(SIGINT, &action, &before_);
  }
  ~Interruptible() { ::sigaction(SIGINT, &before_, nullptr); }
  Interruptible(const Interruptible&) = delete;
  Interruptible& operator=(const Interruptible&) = delete;

 private:
  struct sigaction before_ {};
};

// The arm without limits of its efforts: plausible values define its dynamics, but no such limits.
Model without_efforts(const Model& arm) {
  ModelDescription description = arm.description();
  for (Coordinate& c : description.coordinates)
    c.limits.effort = std::numeric_limits<double>::infinity();
  return Model(std::move(description));
}

// The arm of --model. An arm that was identified with locked joints does not contain them.
Model read_arm_with_values(const ExciteRequest& request) {
  const Model arm = read_model(request.model);
  std::map<std::string, double> fixed;
  for (const auto& [joint, value] : request.common.fixed) {
    for (const Coordinate& c : arm.coordinates())
      if (c.name == joint) fixed[joint] = value;
  }
  return with_fixed(arm, fixed);
}

// Capsules of the links: from the collision shapes of a URDF, or along the links of a given radius.
std::vector<Capsule> capsules_of(const ExciteRequest& request, const Model& arm) {
  if (request.link_radius) return capsules_along_links(arm, *request.link_radius);
  const std::string& file = request.shapes.empty() ? request.robot : request.shapes;
  if (robot_format(file) != RobotFormat::kUrdf) return {};
  std::vector<std::string> remarks;
  std::vector<Capsule> out = collision_capsules(file, remarks);
  for (const std::string& remark : remarks) print_message("warning: " + remark);
  return out;
}

CollisionLimits collisions_of(const ExciteRequest& request, const Model& arm) {
  if (request.collisions == "off") return {};
  const std::vector<Capsule> shapes = capsules_of(request, arm);
  std::vector<Obstacle> around;
  if (request.floor) around.push_back({"floor", {-kInfinity, -kInfinity, -kInfinity}, {kInfinity, kInfinity, *request.floor}});
  for (const std::string& words : request.keep_out) around.push_back(parse_obstacle_box(words));
  expect_value(!shapes.empty() || around.empty(), around.empty() || request.floor ? "--floor" : "--keep-out",
               "'", request.robot, "' has no collision shapes; expected --link-radius, or --shapes with a URDF file");
  expect_value(!shapes.empty() || request.shapes.empty(), "--shapes", "'", request.shapes, "' has no collision shapes");
  return collision_limits(arm, shapes, around, request.clearance.value_or(kLinkClearance));
}

// Sets o.noise to the residual of an identification from the recordings of --noise-of, and o.valued to the identified
// model if there are no other values. Returns the reason if that fails, else "".
std::string estimate_noise(const ExciteRequest& request, const Model& arm, ExcitationOptions& o) {
  IdentificationOptions how;
  how.friction = o.friction;
  how.preprocessing = request.reading;
  how.threads = o.threads;
  const Identification id = identify(arm, request.noise_of, {}, how);
  if (!id.model) return "the noise of " + request.noise_of.front() + " cannot be told: " + id.reason;
  const auto& left = id.model->description().identified;
  if (!left || left->noise.size() != arm.joints() || !(left->noise.minCoeff() > 0.0))
    return "the noise of " + request.noise_of.front() + " cannot be told: a joint has no torque that the model does not explain";
  o.noise = usual_noise(*id.model);
  o.noise->source = fmt::format("what an identification from {} left", fmt::join(request.noise_of, ", "));
  if (!o.powered && !arm.inertial_values()) o.valued = id.model;
  return "";
}

// @param made_up_words  output: a warning if values were made up, else unchanged.
ExcitationOptions options_of(const ExciteRequest& request, const Model& arm,
                             std::string& made_up_words) {
  ExcitationOptions o = request.options;
  o.threads = request.common.threads;
  o.progress = progress(request.common);
  o.stop = [] { return interrupted != 0; };
  for (const std::string& words : request.boxes) o.workspace.boxes.push_back(parse_frame_box(words));
  for (const std::string& words : request.insertions)
    o.workspace.insertions.push_back(parse_insertion_range(words));
  std::vector<Sphere> spheres;
  std::vector<Sphere> obstacles;
  for (const std::string& words : request.spheres) spheres.push_back(parse_sphere(words));
  for (const std::string& words : request.obstacles) obstacles.push_back(parse_obstacle(words));
  o.workspace.pairs = sphere_pairs(spheres, obstacles, request.clearance.value_or(0.0));
  o.workspace.collisions = collisions_of(request, arm);
  for (const std::string& path : request.given) {
    for (MotionSamples& motion : recorded_motion(arm, path, request.reading)) o.given.push_back(std::move(motion));
  }
  if (!request.between.empty()) o.criterion = ExcitationCriterion::kDiscriminate;
  if (!request.model.empty()) o.powered = read_arm_with_values(request);
  const Model moved = with_friction(arm, o.friction);
  if (o.criterion == ExcitationCriterion::kDiscriminate && !o.powered && !arm.inertial_values()) {
    if (!request.common.quiet) {
      made_up_words = text(request.robot,
                           " has no values: the rivals are built from plausible ones (--model "
                           "gives others).");
    }
    o.powered = without_efforts(plausible_model(moved, 1).arm);
  }
  if (!request.between.empty())
    o.between = value_of("--between", [&] { return parse_rivals(o.powered.value_or(arm), request.between); });
  // Missing values are replaced by plausible ones, since deviations relative to a friction of zero are undefined.
  if (!o.powered && !has_all_values(moved)) o.valued = plausible_model(moved, 1).arm;
  if (request.torque_noise)
    o.noise = noise_of_efforts(o.powered ? *o.powered : o.valued ? *o.valued : moved,
                               *request.torque_noise);
  return o;
}

// The limit with the largest violation, relative to its size.
const LimitMargin& most_violated(const Excitation& found) {
  const auto share = [](const LimitMargin& m) {
    const double size = std::isfinite(m.upper - m.lower) ? m.upper - m.lower : std::abs(m.lower);
    return m.margin / std::max(size, 1e-9);
  };
  return *std::min_element(
      found.margins.begin(), found.margins.end(),
      [&](const LimitMargin& a, const LimitMargin& b) { return share(a) < share(b); });
}

// Reason for a missing motion, or empty.
std::string missing_motion_reason(const Excitation& found) {
  if (found.status == ExcitationStatus::kRankDeficient) {
    return text("no motion of ", found.trajectory.harmonics(),
                " harmonics was found that excites all ", found.base_parameters,
                " base parameters; more --harmonics or --starts may help.");
  }
  if (found.status != ExcitationStatus::kLimitsNotMet) return "";
  const LimitMargin& m = most_violated(found);
  return text("the limits cannot be met: ", m.name, " must stay within ", m.lower, " .. ", m.upper,
              " ", m.unit, ", the nearest motion found crosses that by ", -m.margin, " ", m.unit,
              "; nothing is written.");
}

// Throws if the solver was not built; it is not replaced by another.
void expect_solver(const ExciteRequest& request) {
  const ExcitationSolver solver = request.options.solver;
  expect_value(is_built_in(solver), "--solver", "found '", name_of(solver),
               "', with which this program was not built; expected interior-point or random, or a build beside ",
               solver == ExcitationSolver::kIpopt ? "coinor-libipopt-dev" : "libnlopt-dev");
}

// All inputs of the searches as text: the given options and the contents of the files that they name.
std::string search_words(const CLI::App& command) {
  static const std::set<std::string> kOfTheResult = {"--output", "--coefficients", "--json", "--report", "--resume", "--speed", "--threads", "--quiet"};
  std::string out = VERIDYN_VERSION;
  for (const CLI::Option* option : command.get_options()) {
    if (option->count() == 0 || kOfTheResult.count(option->get_name()) > 0) continue;
    out += "\n" + option->get_name();
    for (const std::string& word : option->results()) out += " " + word + " " + sha256_of_file(word);
  }
  return out;
}

ExitStatus run(const ExciteRequest& request, const std::string& command_line) {
  expect_solver(request);
  for (const std::string* path :
       {&request.common.json, &request.common.report, &request.coefficients})
    require_writable(*path);
  require_writable(request.output);
  if (request.extension) {
    const std::optional<ExitStatus> done =
        request.extension->run({request.command, request.robot, request.output, request.options.seed,
                                request.options.limit_share, request.common});
    if (done) return *done;
  }
  const bool discriminates = request.options.criterion == ExcitationCriterion::kDiscriminate;
  expect_prerequisites(*request.command,
                       {{"--between", discriminates || request.command->count("--criterion") == 0,
                         "--criterion discriminate"},
                        {"--obstacle", !request.spheres.empty(), "--sphere"},
                        {"--shapes", !request.link_radius, "no --link-radius"}});
  for (const char* option : {"--shapes", "--link-radius", "--floor", "--keep-out"})
    expect_prerequisites(*request.command, {{option, request.collisions != "off", "--collisions auto"}});
  for (const char* option : {"--columns", "--given-rate", "--topic", "--map", "--units", "--rows"})
    expect_prerequisites(*request.command, {{option, !request.given.empty() || !request.noise_of.empty(), "--given or --noise-of"}});
  expect_value(!discriminates || !request.between.empty(), "--criterion",
               "discriminate needs --between");
  const Model arm = read_robot(request.robot, request.common);
  warn_of_impossible_bodies(request.robot, arm);
  require(arm.joints() > 0, request.robot, ": found no coordinates, expected some to move.");
  require_ranges_in_radians(arm, request.robot);
  std::vector<std::string> recordings = request.given;
  recordings.insert(recordings.end(), request.noise_of.begin(), request.noise_of.end());
  if (!recordings.empty()) check_recordings(arm, recordings, request.reading, request.common.threads);
  std::string made_up_words;
  ExcitationOptions options = options_of(request, arm, made_up_words);
  const std::string unknown = request.noise_of.empty() ? "" : estimate_noise(request, arm, options);
  if (!unknown.empty()) {
    print_message(unknown + ".");
    return kDataCannotAnswer;
  }
  std::optional<KeptResults> searches;
  if (!request.resume.empty()) {
    searches.emplace(request.resume, "excite: searches", search_words(*request.command));
    options.kept = [&](int start) { return searches->find(start); };
    options.keep = [&](int start, const VectorXd& numbers) { searches->keep(start, numbers); };
  }
  if (!made_up_words.empty()) print_message(made_up_words);
  expect_prerequisites(*request.command,
                       {{"--clearance", !request.spheres.empty() || !options.workspace.collisions.pairs.empty(),
                         "--sphere, or an arm with collision shapes"}});
  const std::vector<std::string>& impossible = options.workspace.collisions.impossible;
  if (!impossible.empty()) {
    print_message("the limits cannot be met: " + impossible.front() + " touch at every posture" +
        (impossible.size() > 1 ? text(" (and ", impossible.size() - 1, " more)") : "") +
        "; move the obstacle, or give links another --link-radius or --shapes; nothing is written.");
    return kDataCannotAnswer;
  }
  const Interruptible until_interrupted;
  // Exceptions here come from option values that do not fit this arm.
  Excitation found = value_of("excite", [&] { return optimise_excitation(arm, options); });
  const bool known = arm.inertial_values() || !request.model.empty();
  if (found.prediction && !known)
    found.prediction->values = "of a plausible arm (" + request.robot + " has none)";
  else if (found.prediction && request.model.empty() && !has_all_values(with_friction(arm, options.friction)))
    found.prediction->values = "of " + arm.name() + " with plausible friction (" + request.robot + " has none)";
  const std::string problem = missing_motion_reason(found);
  if (!problem.empty()) {
    print_message(problem);
    return kDataCannotAnswer;
  }
  Recording rows;
  rows.time = found.motion.time;
  rows.q = found.motion.q;
  rows.dq = found.motion.dq;
  rows.ddq = found.motion.ddq;
  write_recording(rows, request.output);
  if (!request.coefficients.empty()) write_file(request.coefficients, coefficients_yaml(found));
  write_results(request.common, found, command_line, &arm);
  for (const std::string& warning : found.warnings()) print_message("warning: " + warning);
  std::cout << found.report();
  return found.interrupted ? kInterrupted : kDone;
}

void add_limit_options(CLI::App& command, ExciteRequest& r) {
  const char* const group = "Limits beside those of the robot file";
  const auto several = [&](const char* option, std::vector<std::string>& target, const char* form,
                           const char* help) {
    command.add_option(option, target, help)
        ->option_text(form)
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
        ->group(group);
  };
  add_value(command, "--model FILE", r.model,
            "Model with values, for torque limits and for causes to discriminate")
      ->group(group);
  several("--box", r.boxes, "FRAME:X,X,Y,Y,Z,Z",
          "Keep the origin of a frame inside a box, in world coordinates");
  several("--sphere", r.spheres, "FRAME:R[,X,Y,Z]",
          "Sphere around a point of a frame, kept clear of other spheres and of obstacles");
  several("--obstacle", r.obstacles, "X,Y,Z,R", "Spherical obstacle in world coordinates");
  add_value(command, "--collisions auto|off", r.collisions,
            "Keep links apart from each other, from the mount and from obstacles; auto: where "
            "their shapes are known",
            CLI::IsMember({"auto", "off"}))
      ->group(group);
  add_value(command, "--shapes FILE", r.shapes,
            "URDF file with the collision shapes of the links (default: ROBOT)", CLI::ExistingFile)
      ->group(group);
  add_value(command, "--link-radius M", r.link_radius,
            "Model links as capsules of this radius along the lines between joints [m]",
            CLI::PositiveNumber)
      ->group(group);
  add_value(command, "--floor Z", r.floor, "Height of a floor, above which links stay [m]")
      ->group(group);
  several("--keep-out", r.keep_out, "X,X,Y,Y,Z,Z",
          "Box in world coordinates that links stay out of, as a table or a mount");
  add_value(command, "--clearance M", r.clearance,
            "Clearance between spheres (default: 0) and between links (default: 0.01) [m]",
            CLI::NonNegativeNumber)
      ->group(group);
  several("--insertion", r.insertions, "FRAME:LOW,HIGH[,X,Y,Z]",
          "Bounds of a frame's insertion depth through a remote centre (default: the world's "
          "origin), along its z axis");
}

}  // namespace

void add_excite_command(CLI::App& tool, Outcome& outcome, const std::optional<ExciteExtension>& extension) {
  const auto request = std::make_shared<ExciteRequest>();
  request->extension = extension;
  CLI::App& command = *tool.add_subcommand("excite", "Design an excitation trajectory");
  add_robot_argument(command, request->robot);
  add_output_option(command, "-o,--output", request->output, "Write the motion as CSV: t, q, dq, ddq", {".csv"})->required();
  add_output_option(command, "--coefficients", request->coefficients, "Write the series' coefficients as YAML");
  add_value(
      command, "--resume FILE", request->resume,
      "Keep each finished search in this file; after a kill the same command goes on from it");
  add_motion_options(command, request->options);
  add_search_options(command, request->options);
  add_value(command, "--between EFFECT:PLACE,EFFECT:PLACE", request->between,
            "Two causes to discriminate, with --criterion discriminate")
      ->group("Search");
  add_value(command, "--given FILE...", request->given, "Recordings to add information to")
      ->group("Search");
  add_value(command, "--torque-noise X", request->torque_noise,
            "Torque noise as a share of the largest effort (default: the model's error, or 0.01 "
            "for the design and 0.2 of the rms torque along the motion for predicted deviations)",
            CLI::Range(1e-6, 10.0))
      ->group("Search");
  add_value(
      command, "--noise-of REC...", request->noise_of,
      "Take the torque noise from what an identification from these recordings of the arm leaves")
      ->excludes("--torque-noise")
      ->group("Search");
  add_limit_options(command, *request);
  add_headerless_options(command, request->reading.columns, request->reading.header_rate, "--given-rate");
  add_signal_options(command, request->reading.signals);
  add_row_range(command, "--rows", "Samples of the recordings of --given and --noise-of",
                [request](RowRange rows) {
                  request->reading.first_row = rows.first;
                  request->reading.row_count = rows.count;
                });
  add_robot_options(command, request->common);
  if (extension) extension->add_options(command);
  add_report_option(command, request->common);
  add_common_options(command, request->common);
  request->command = &command;
  command.callback([request, &outcome] { outcome.status = run(*request, outcome.command_line); });
}

}  // namespace veridyn::cli
