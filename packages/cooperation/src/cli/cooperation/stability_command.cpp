#include <cmath>
#include <iostream>
#include <memory>
#include <optional>

#include "veridyn/files/words.hpp"
#include "cli/cooperation/commands.hpp"
#include "veridyn/tool/common_options.hpp"
#include "veridyn/tool/messages.hpp"
#include "veridyn/tool/option_checks.hpp"
#include "cooperation/scenario/scenario_models.hpp"
#include "veridyn/cooperation/stability.hpp"
#include "veridyn/files/output_file.hpp"
#include "report/json/stability_json.hpp"

namespace veridyn::cli {
namespace {

struct StabilityRequest {
  std::string scenario, map, locus, frame;
  std::vector<std::string> set;
  std::vector<double> pose;
  double recommend = 0.0;
  int bounds = 0;
  CommonOptions common;
};

// The scenario with a setting such as "stiffness=1e4"; a usage error of --set for another form.
Scenario with_setting(Scenario scenario, const std::string& word) {
  const auto equals = word.find('=');
  expect_value(equals != std::string::npos && equals > 0, "--set", "found '", word,
               "', expected NAME=VALUE.");
  const std::optional<double> value = number_in(word.substr(equals + 1));
  expect_value(value && std::isfinite(*value), "--set", "found '", word,
               "', expected NAME=VALUE with a number.");
  return value_of("--set", [&] { return with_parameter(scenario, word.substr(0, equals), *value); });
}

struct Ranges {
  std::optional<ParameterRange> a, b, locus;
};

// Ranges of --map and --locus.
Ranges parsed_ranges(const StabilityRequest& request) {
  Ranges out;
  if (!request.map.empty()) {
    const auto comma = request.map.find(',');
    expect_value(comma != std::string::npos, "--map", "found '", request.map,
                 "', expected two ranges, A=FROM:TO:COUNT,B=FROM:TO:COUNT.");
    out.a = value_of("--map", [&] { return parse_range(request.map.substr(0, comma)); });
    out.b = value_of("--map", [&] { return parse_range(request.map.substr(comma + 1)); });
    expect_value(out.a->name != out.b->name, "--map", "found ", out.a->name,
                 " twice, expected two different parameters.");
  }
  if (!request.locus.empty())
    out.locus = value_of("--locus", [&] { return parse_range(request.locus); });
  return out;
}

ExitStatus run(const StabilityRequest& request, const std::string& command) {
  require_writable(request.common.json, request.common.report);
  const Ranges asked = parsed_ranges(request);
  StabilityModelOptions of_model;
  of_model.frame = request.frame;
  of_model.pose = request.pose;
  Scenario scenario = read_scenario_or_model(request.scenario, of_model);
  for (const std::string& word : request.set) scenario = with_setting(std::move(scenario), word);
  for (const std::string& line : assumed_values(scenario)) {
    if (!request.common.quiet) print_message(line);
  }
  const Progress bar = progress(request.common);
  const auto told = [&](const char* what) {
    if (bar) bar(what, 0.0);
  };
  StabilityStudy study;
  study.scenario = scenario;
  told("eigenvalues and margins");
  study.analysis = analyse_stability(scenario);
  if (asked.a) {
    told("map");
    study.map = map_stability(scenario, *asked.a, *asked.b, request.common.threads);
  }
  if (asked.locus) {
    told("root locus");
    study.locus = root_locus(scenario, *asked.locus);
  }
  if (request.recommend > 0.0) {
    told("recommended gains");
    study.recommendation = recommend_gains(scenario, request.recommend);
  }
  if (request.bounds > 0) {
    told("bounds over the parameters' intervals");
    study.bounds = bound_stability(scenario, request.bounds, request.common.threads);
  }
  if (!request.common.report.empty()) {
    told("step responses");
    study.steps = step_responses(scenario);
  }
  write_results(request.common, study, command);
  std::cout << study.report();
  return kDone;
}

}  // namespace

void add_stability_command(CLI::App& tool, Outcome& outcome) {
  const auto request = std::make_shared<StabilityRequest>();
  CLI::App& command = *tool.add_subcommand(
      "stability", "Linear stability of a cooperation loop: eigenvalues, margins, maps");
  add_value(command, "SCENARIO", request->scenario,
            "YAML of a scenario; or a MODEL: its impedance against a wall")
      ->required();
  add_value(command, "--set NAME=VALUE", request->set, "Change a parameter of the scenario first")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  add_value(command, "--map A=FROM:TO:COUNT,B=FROM:TO:COUNT", request->map,
            "Map of stability over two parameters");
  add_value(command, "--locus A=FROM:TO:COUNT", request->locus, "Root locus over one parameter");
  add_value(command, "--recommend DEGREES", request->recommend,
            "Recommend gains with at least this phase margin [deg]", CLI::Range(1.0, 120.0));
  add_value(command, "--bounds COUNT", request->bounds,
            "Worst margins over the intervals of all parameters, from so many samples",
            CLI::Range(1, 10000));
  add_value(command, "--frame NAME", request->frame, "With a MODEL: frame that is in contact");
  add_value(command, "--pose Q1,Q2,...", request->pose,
            "With a MODEL: joint positions (default: middle of the ranges)")
      ->delimiter(',');
  add_common_options(command, request->common);
  add_report_option(command, request->common);
  command.callback([request, &outcome] { outcome.status = run(*request, outcome.command_line); });
}

}  // namespace veridyn::cli
