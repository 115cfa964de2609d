#include "veridyn/tool/option_checks.hpp"

#include <algorithm>

#include "model/suggestion.hpp"

namespace veridyn::cli {

void expect_prerequisites(const CLI::App& command, const std::vector<OptionNeed>& needs) {
  for (const OptionNeed& need : needs) {
    if (!need.met && command.count(need.option) > 0)
      throw CLI::ValidationError(need.option,
                                 std::string("means nothing here, it needs ") + need.needs);
  }
}

void expect_one_of(const std::string& option, const std::string& value,
                   const std::vector<std::string>& names) {
  expect_value(std::find(names.begin(), names.end(), value) != names.end(), option, "found '",
               value, "'", did_you_mean(value, names), ", expected one of: ", listed(names));
}

std::vector<std::string> frame_names(const Model& arm) {
  std::vector<std::string> names;
  for (const Frame& frame : arm.frames()) names.push_back(frame.name);
  return names;
}

}  // namespace veridyn::cli
