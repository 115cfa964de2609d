// Measures how often diagnose finds hidden causes in recordings of arms whose dynamics and effects share no code
// with the library. See docs/measure.md; the tests are in hide_and_seek_test.cpp.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <fstream>

#include "hide_and_seek/blind.hpp"
#include "hide_and_seek/detection_limit.hpp"
#include "hide_and_seek/outside.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::seek {
namespace {

constexpr double kDvrkNoise = 0.04;  // white and coloured of the noise preset `dvrk`

struct Request {
  BoardRequest board;
  double cutoff = 0.0;
  bool derived_velocity = false;
  bool least_squares = false;
  std::vector<std::string> set;
  std::string folder, answers, truth, output, journal;
  std::vector<double> sizes = {0.01, 0.02, 0.04, 0.08, 0.16};
};

// @param setting  "NAME=VALUE". @throws InvalidInput  there is no threshold of this name, or the value is no number.
void set_threshold(const std::string& setting, DiagnosisOptions& options) {
  const size_t equals = setting.find('=');
  const std::string value = equals == std::string::npos ? "" : setting.substr(equals + 1);
  char* end = nullptr;
  const double number = std::strtod(value.c_str(), &end);
  require(!value.empty() && *end == '\0' && std::isfinite(number), "--set: found '", setting,
          "', expected NAME=VALUE.");
  options.thresholds.*find_threshold(setting.substr(0, equals)).value = number;
}

void add_board_options(CLI::App& app, Request& request) {
  BoardRequest& board = request.board;
  app.add_option("--arms", board.arms, "Arms of tests/hide_and_seek/robots or data/robots")
      ->delimiter(',');
  app.add_option("--effects", board.effects,
                 "Names of effects, none, or " + fmt::format("{}", fmt::join(special_cases(), ", ")))
      ->delimiter(',');
  app.add_option("--seeds", board.seeds, "Seeds")->delimiter(',');
  app.add_option("--size", board.share, "Rms of the effect, share of its joint's rms torque");
  app.add_option("--mode", board.mode, "bare, changed or both")
      ->check(CLI::IsMember({"bare", "changed", "both"}));
  app.add_option("--troubles", board.troubles, "What all recordings suffer from, each alone")
      ->delimiter(',');
  app.add_option("--pairs", board.pairs, "Two effects at once: so many per arm and seed");
  app.add_flag("--one-joint", board.one_joint, "Pairs on one joint: the first of --effects and one of the others");
  app.add_option("--noise", board.noise, "Of the torques, share of the joint's rms torque");
  app.add_option("--threads", board.threads, "Of diagnose");
  app.add_option("--json", board.json, "Append one record per case to this file");
  app.add_option("--keep", board.keep, "Keep the recordings in this folder");
  app.add_option("--resume", request.journal,
                 "File of finished cases: those in it are not played again, the others are added; after a kill the same "
                 "command goes on");
  app.add_flag("--well-visible", board.well_visible,
               "Skip cases below three times the smallest detectable size");
  app.add_option("--filter-cutoff", request.cutoff, "[Hz] instead of the default of diagnose");
  app.add_flag("--derived-velocity", request.derived_velocity,
               "Velocity from q instead of the recorded one");
  app.add_option("--set", request.set, "NAME=VALUE of a threshold of diagnose")->delimiter(',');
}

void apply(Request& request) {
  PreprocessingOptions& how = request.board.options.identification.preprocessing;
  if (request.cutoff > 0.0) how.cutoff = request.cutoff;
  if (request.derived_velocity) how.velocity = VelocitySource::kDerived;
  request.board.options.identification.threads = request.board.threads;
  if (!request.journal.empty()) request.board.journal = std::make_shared<Journal>(request.journal);
  for (const std::string& setting : request.set) set_threshold(setting, request.board.options);
}

void play_board(const Request& request) {
  const std::vector<Outcome> all = play_all(request.board);
  print_table(all, "all cases");
  std::vector<Outcome> seen;
  std::copy_if(all.begin(), all.end(), std::back_inserter(seen), [](const Outcome& o) {
    return o.observable && (o.best_gain >= kWellVisible || o.verdict.hidden == 0);
  });
  print_table(seen, "cases at or above three times the smallest detectable size");
}

int run(int argc, char** argv) {
  Request request;
  CLI::App app("How often diagnose finds what is hidden");
  add_board_options(app, request);
  app.require_subcommand(0, 1);

  CLI::App* exporting = app.add_subcommand("export", "Write cases for any tool to answer");
  exporting->add_option("DIR", request.folder, "Folder of the cases")->required();
  exporting->add_option("--truth", request.truth, "What is hidden (default: DIR.truth.json)");
  add_board_options(*exporting, request);

  CLI::App* scoring = app.add_subcommand("score", "Judge the answers of a tool");
  scoring->add_option("DIR", request.folder, "Folder of the cases")->required();
  scoring->add_option("ANSWERS", request.answers, "JSON file of answers")->required();
  scoring->add_option("--truth", request.truth, "What is hidden (default: DIR.truth.json)");

  CLI::App* answering = app.add_subcommand("answer", "Answer the cases of a folder by diagnose");
  answering->add_option("DIR", request.folder, "Folder of the cases")->required();
  answering->add_option("-o,--output", request.output, "JSON file of answers")->required();
  answering->add_option("--threads", request.board.threads, "Of diagnose");
  answering->add_flag("--least-squares", request.least_squares,
                      "Instead of diagnose: least squares with one more effect at a time");

  CLI::App* limits = app.add_subcommand("limits", "At which size effects are named");
  limits->add_option("--sizes", request.sizes, "Shares of the joint's rms torque")->delimiter(',');
  add_board_options(*limits, request);

  CLI::App* outside = app.add_subcommand("outside", "Causes that are on nobody's list: " +
                                                        fmt::format("{}", fmt::join(outside_causes(), ", ")));
  add_board_options(*outside, request);

  CLI11_PARSE(app, argc, argv);

  apply(request);
  if (request.truth.empty()) request.truth = request.folder + ".truth.json";
  if (exporting->parsed()) {
    export_cases(request.board, request.folder, request.truth);
  } else if (scoring->parsed()) {
    print_table(score(request.folder, request.answers, request.truth), "all cases");
  } else if (answering->parsed()) {
    std::ofstream file(request.output);
    file << (request.least_squares
                 ? answer_cases_by_least_squares(request.folder, request.board.threads)
                 : answer_cases(request.folder, request.board.options))
                .dump(1)
         << "\n";
    require(file.good(), request.output, ": cannot be written.");
  } else if (limits->parsed()) {
    if (request.board.noise <= 0.0) request.board.noise = kDvrkNoise;
    print_detection_limits(request.board, request.sizes);
  } else if (outside->parsed()) {
    OutsideRequest asked;
    asked.causes = request.board.effects;
    asked.arms = request.board.arms;
    asked.seeds = request.board.seeds;
    if (outside->count("--size") > 0) asked.share = request.board.share;
    asked.threads = request.board.threads;
    asked.keep = request.board.keep;
    asked.options = request.board.options;
    play_outside(asked);
  } else {
    play_board(request);
  }
  return 0;
}

}  // namespace
}  // namespace veridyn::seek

int main(int argc, char** argv) {
  try {
    return veridyn::seek::run(argc, argv);
  } catch (const veridyn::InvalidInput& error) {
    fmt::print(stderr, "veridyn-hide-and-seek: {}\n", error.what());
    return 3;
  }
}
