#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string_view>

#include "cli/commands.hpp"
#include "veridyn/tool/common_options.hpp"
#include "veridyn/tool/option_checks.hpp"
#include "veridyn/diagnosis/thresholds.hpp"

namespace veridyn {

std::string_view number_file(std::string_view name);  // content of a header, embedded by cmake/embed_files.cmake

namespace cli {
namespace {

constexpr std::string_view kTypes[] = {"double ", "int ", "long ", "std::size_t "};

void print_numbers_of_diagnosis() {
  fmt::print("diagnose (src/diagnosis/thresholds.cpp)\n");
  const Thresholds defaults;
  for (const ThresholdEntry& one : threshold_table())
    fmt::print("  {:<28} {:<8g} {}\n  {:<37} because {}\n", one.name, defaults.*one.value, one.inequality, "", one.reason);
}

// Prints the numbers of a header, each below its comment with the inequality and the reason.
void print_numbers_in(std::string_view header) {
  std::string comment;
  while (!header.empty()) {
    std::string_view line = header.substr(0, header.find('\n'));
    header.remove_prefix(std::min(line.size() + 1, header.size()));
    line.remove_prefix(std::min(line.find_first_not_of(' '), line.size()));
    const size_t type = line.rfind("constexpr ", 0) == 0 ? line.find(' ') + 1 : 0;
    const bool number = std::any_of(std::begin(kTypes), std::end(kTypes), [&](std::string_view t) { return line.compare(type, t.size(), t) == 0; });
    if (line.rfind("//", 0) == 0) {
      comment += fmt::format("  {}\n", line.substr(std::min(line.find_first_not_of("/ "), line.size())));
    } else if (number && line.find(" = ") != line.npos) {
      fmt::print("{}      {}\n", comment, line.substr(line.find(' ', type) + 1));
    }
    if (line.rfind("//", 0) != 0) comment.clear();
  }
}

void print_numbers(const std::string& wanted) {
  std::vector<std::string> names{"diagnose"}, files{""};
  for (const std::string& table : CLI::detail::split(VERIDYN_NUMBER_TABLES, ' ')) {
    const size_t colon = table.find(':');
    if (colon == table.npos) continue;
    names.push_back(table.substr(0, colon));
    files.push_back(table.substr(colon + 1));
  }
  if (!wanted.empty()) expect_one_of("TABLE", wanted, names);
  if (wanted.empty() || wanted == "diagnose") print_numbers_of_diagnosis();
  for (size_t k = 1; k < names.size(); ++k) {
    if (!wanted.empty() && names[k] != wanted) continue;
    fmt::print("{} ({})\n", names[k], files[k]);
    print_numbers_in(number_file(names[k]));
  }
}

}  // namespace

void add_numbers_command(CLI::App& tool) {
  const auto wanted = std::make_shared<std::string>();
  CLI::App& command = *tool.add_subcommand("numbers", "Numbers that decide what the other commands answer");
  add_value(command, "TABLE", *wanted, "One table: diagnose, watch, fleet, ... (all)");
  command.callback([wanted] { print_numbers(*wanted); });
}

}  // namespace cli
}  // namespace veridyn
