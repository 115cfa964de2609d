#include <fmt/format.h>

#include <memory>

#include "cli/commands.hpp"
#include "veridyn/tool/common_options.hpp"
#include "veridyn/tool/option_checks.hpp"
#include "diagnosis/comparison/comparison_numbers.hpp"
#include "diagnosis/search/numbers.hpp"
#include "identification/estimation/estimation_numbers.hpp"
#include "identification/fleet/fleet_numbers.hpp"
#include "identification/identification_numbers.hpp"
#include "recordings/quality/quality_numbers.hpp"
#include "veridyn/diagnosis/thresholds.hpp"
#include "diagnosis/watch/watch_numbers.hpp"

namespace veridyn::cli {
namespace {

/// The numbers of one folder. The file has the inequality and the reason of each.
struct NumberTable {
  std::string name, file;
  std::vector<std::pair<std::string, double>> numbers;
};

template <typename Numbers>
NumberTable number_table(const char* name, const char* file, const std::vector<TableNumber<Numbers>>& numbers) {
  NumberTable out{name, file, {}};
  for (const TableNumber<Numbers>& one : numbers) out.numbers.emplace_back(one.name, one.in(Numbers()));
  return out;
}

std::vector<NumberTable> number_tables() {
  return {number_table("quality", "src/recordings/quality/quality_numbers.hpp", quality_numbers()),
          number_table("identify", "src/identification/identification_numbers.hpp", identification_numbers()),
          number_table("estimation", "src/identification/estimation/estimation_numbers.hpp", estimation_numbers()),
          number_table("fleet", "src/identification/fleet/fleet_numbers.hpp", fleet_numbers()),
          number_table("compare", "src/diagnosis/comparison/comparison_numbers.hpp", comparison_numbers()),
          number_table("watch", "src/diagnosis/watch/watch_numbers.hpp", watch_numbers()),
          {"search", "src/diagnosis/search/numbers.hpp", {{"errors", search::kErrors}, {"smallest", search::kSmallest}, {"seldom", search::kSeldom},
           {"constant", search::kConstant}, {"imitator", search::kImitator}, {"curve", search::kCurve}, {"curve_of_two", search::kCurveOfTwo},
           {"polished", search::kPolished}, {"day", search::kDay}}}};
}

void print_numbers_of_diagnosis() {
  fmt::print("diagnose (src/diagnosis/thresholds.cpp)\n");
  const Thresholds defaults;
  for (const ThresholdEntry& one : threshold_table())
    fmt::print("  {:<28} {:<8g} {}\n  {:<37} because {}\n", one.name, defaults.*one.value, one.inequality, "", one.reason);
}

void print_numbers(const std::string& wanted) {
  const std::vector<NumberTable> tables = number_tables();
  std::vector<std::string> names{"diagnose"};
  for (const NumberTable& one : tables) names.push_back(one.name);
  if (!wanted.empty()) expect_one_of("TABLE", wanted, names);
  if (wanted.empty() || wanted == "diagnose") print_numbers_of_diagnosis();
  for (const NumberTable& one : tables) {
    if (!wanted.empty() && one.name != wanted) continue;
    fmt::print("{} ({})\n", one.name, one.file);
    for (const auto& [name, value] : one.numbers) fmt::print("  {:<28} {:g}\n", name, value);
  }
}

}  // namespace

void add_numbers_command(CLI::App& tool) {
  const auto wanted = std::make_shared<std::string>();
  CLI::App& command = *tool.add_subcommand("numbers", "Numbers that decide what the other commands answer");
  add_value(command, "TABLE", *wanted, "One table: diagnose, watch, fleet, ... (all)");
  command.callback([wanted] { print_numbers(*wanted); });
}

}  // namespace veridyn::cli
