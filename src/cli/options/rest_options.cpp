#include "cli/options/rest_options.hpp"

#include <algorithm>

#include "veridyn/tool/common_options.hpp"
#include "veridyn/tool/option_checks.hpp"

namespace veridyn::cli {

void add_rest_options(CLI::App& command, RestRequest& request, const std::string& identifies) {
  command.add_flag("--at-rest", request.at_rest,
                   "Recordings of poses at rest, with or without time: " + identifies +
                       " (default if every recorded velocity is zero)");
  add_value(command, "--approach 1,-1,...", request.approach,
            "With --at-rest: direction from which the poses of each recording were approached "
            "(default: columns dq1.. of -1, 0 and 1)",
            CLI::IsMember({-1, 0, 1}))
      ->delimiter(',');
}

bool are_rest_poses(const RestRequest& request, const Model& arm, const std::vector<std::string>& train,
               const PreprocessingOptions& how) {
  if (request.at_rest || !request.approach.empty()) return true;
  return !train.empty() && std::all_of(train.begin(), train.end(),
                                       [&](const std::string& path) { return is_at_rest(arm, path, how); });
}

std::pair<std::vector<Recording>, std::vector<Recording>> read_poses(
    const RestRequest& request, const Model& arm, const std::vector<std::string>& train,
    const std::vector<std::string>& test, const IdentificationOptions& options) {
  const std::vector<double>& sides = request.approach;
  expect_value(sides.empty() || sides.size() == train.size() || sides.size() == train.size() + test.size(),
               "--approach", "found ", sides.size(), " numbers, expected one for each of the ", train.size(),
               " training recordings (and of the ", test.size(), " held out)");
  const auto read = [&](const std::vector<std::string>& paths, std::size_t first,
                        const PreprocessingOptions& how) {
    std::vector<Recording> out;
    for (std::size_t k = 0; k < paths.size(); ++k) {
      const bool given = first + k < sides.size();
      out.push_back(read_rest_poses(arm, paths[k], how,
                                    given ? std::optional<double>(sides[first + k]) : std::nullopt));
    }
    return out;
  };
  return {read(train, 0, options.preprocessing),
          read(test, train.size(), options.test_preprocessing.value_or(options.preprocessing))};
}

}  // namespace veridyn::cli
