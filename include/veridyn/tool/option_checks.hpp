#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <utility>
#include <vector>

#include "veridyn/math/require.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn::cli {

/// A prerequisite of an option.
struct OptionNeed {
  const char* option;  ///< name of the option, such as "--kp"
  bool met;            ///< true if the prerequisite is met
  const char* needs;   ///< the prerequisite in words: "--controller pid"
};

/// Rejects options that would have no effect.
/// @throws CLI::ValidationError  names the first of them and its prerequisite.
void expect_prerequisites(const CLI::App& command, const std::vector<OptionNeed>& needs);

/// Calls make() and reports its error as wrong usage of an option, not as bad input. Files must be read
/// outside of make().
/// @throws CLI::ValidationError  in place of InvalidInput, beginning with the option.
template <typename Make>
auto value_of(const std::string& option, Make&& make) {
  try {
    return std::forward<Make>(make)();
  } catch (const InvalidInput& error) {
    throw CLI::ValidationError(option, error.what());
  }
}

/// @throws CLI::ValidationError  the option's value is none of the names; with a suggestion.
void expect_one_of(const std::string& option, const std::string& value,
                   const std::vector<std::string>& names);

/// The names of an arm's frames, for expect_one_of().
std::vector<std::string> frame_names(const Model& arm);

/// @throws CLI::ValidationError  with the option and the given parts, unless the condition holds.
template <typename... Parts>
void expect_value(bool condition, const std::string& option, const Parts&... parts) {
  if (!condition) throw CLI::ValidationError(option, text(parts...));
}

}  // namespace veridyn::cli
