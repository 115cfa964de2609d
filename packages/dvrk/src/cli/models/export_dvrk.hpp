#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "veridyn/tool/file_to_write.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn::cli {

/// Files that laboratories with a da Vinci Research Kit use.
struct DvrkExport {
  std::string gravity;  ///< file for the rows of gravity compensation
  std::string scales;   ///< file for current per effort
  std::string arm;      ///< "PSM1"; empty: from the model's name
  std::string config;   ///< configuration to correct by the scales; empty: the arm's nominal one
  std::string torques;  ///< static torques to compare the rows with
};

/// Adds --dvrk-gravity, --dvrk-scales, --dvrk-arm, --dvrk-config, --static-torques.
void add_dvrk_export_options(CLI::App& command, DvrkExport& request);

/// @throws CLI::ValidationError  an option without the output that it belongs to.
void check_dvrk_export(const DvrkExport& request);

/// Adds the requested files, which print their accuracy.
void add_dvrk_files(const Model& model, const DvrkExport& request, std::vector<FileToWrite>& files);

}  // namespace veridyn::cli
