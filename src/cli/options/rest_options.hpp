#pragma once

#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "veridyn/identification/rest_poses.hpp"

namespace veridyn::cli {

/// --at-rest and --approach.
struct RestRequest {
  bool at_rest = false;
  std::vector<double> approach;  ///< of every recording; empty: as it says
};

/// @param identifies  what the command does with poses, for --help.
void add_rest_options(CLI::App& command, RestRequest& request, const std::string& identifies);

/// True where the options say that recordings are of poses, or every training recording shows it.
bool are_rest_poses(const RestRequest& request, const Model& arm, const std::vector<std::string>& train,
               const PreprocessingOptions& how);

/// Poses of the training and of the held-out recordings.
std::pair<std::vector<RestPoses>, std::vector<RestPoses>> read_poses(
    const RestRequest& request, const Model& arm, const std::vector<std::string>& train,
    const std::vector<std::string>& test, const IdentificationOptions& options);

}  // namespace veridyn::cli
