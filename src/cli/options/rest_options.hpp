#pragma once

#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "veridyn/identification/rest_poses.hpp"

namespace veridyn::cli {

/// Values of --at-rest and --approach.
struct RestRequest {
  bool at_rest = false;
  std::vector<double> approach;  ///< direction of approach of every recording; empty: that of the files
};

/// @param identifies  text for --help: what the command identifies from poses.
void add_rest_options(CLI::App& command, RestRequest& request, const std::string& identifies);

/// True if the options declare recordings of poses, or if every training recording is one.
bool are_rest_poses(const RestRequest& request, const Model& arm, const std::vector<std::string>& train,
               const PreprocessingOptions& how);

/// Reads the poses of the training and of the held-out recordings.
std::pair<std::vector<Recording>, std::vector<Recording>> read_poses(
    const RestRequest& request, const Model& arm, const std::vector<std::string>& train,
    const std::vector<std::string>& test, const IdentificationOptions& options);

}  // namespace veridyn::cli
